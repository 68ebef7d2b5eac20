"""Codecs: what is stored comes back, to half a quantum."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from store import codec

QUANTUM = 1e-4
IN_RANGE = st.floats(-3.27, 3.27)


@given(hnp.arrays(np.float64, hnp.array_shapes(min_dims=1, max_dims=3), elements=IN_RANGE))
def test_fixed_point_is_off_by_half_a_quantum_at_most(values: np.ndarray) -> None:
    stored = codec.encode(values, "int16", QUANTUM)
    assert stored.dtype == np.int16
    # Decoded values are float32: 2^-22 m is its rounding below 4 m.
    assert np.abs(codec.decode(stored, QUANTUM) - values).max() <= QUANTUM / 2 + 2.0**-22


@given(hnp.arrays(np.int16, hnp.array_shapes(max_dims=3)))
def test_decoded_values_encode_to_the_same_integers(stored: np.ndarray) -> None:
    again = codec.encode(codec.decode(stored, QUANTUM), "int16", QUANTUM)
    np.testing.assert_array_equal(again, stored)


@pytest.mark.parametrize("dtype", ["float32", "int32", "int8", "bool", "any"])
@given(data=st.data())
def test_exact_types_come_back_as_they_were(dtype: str, data: st.DataObject) -> None:
    kind = np.dtype("float64" if dtype == "any" else dtype)
    elements = {"allow_nan": False, "allow_infinity": False} if kind.kind == "f" else {}
    shape = hnp.array_shapes(min_dims=0, max_dims=3, min_side=0)
    values = data.draw(hnp.arrays(kind, shape, elements=elements))
    stored = codec.encode(values, dtype, 0.0)
    assert stored.dtype == kind and stored.shape == values.shape
    np.testing.assert_array_equal(codec.decode(stored, 0.0), values)


@pytest.mark.parametrize(
    ("values", "dtype", "quantum", "message"),
    [
        (
            np.array([[0.0, 3.3]]),
            "int16",
            QUANTUM,
            r"value at \(0, 1\) must be from -3.2768 to 3.2767 \(int16\), got 3.3",
        ),
        (np.array([0, 2**31]), "int32", 0.0, r"value at \(1,\) must be from .* \(int32\), got 2.14748e\+09"),
        (np.array([1.0, np.nan]), "float32", 0.0, r"value at \(1,\) must be finite, got nan"),
        (np.array([1.0, -np.inf]), "int16", QUANTUM, r"value at \(1,\) must be finite, got -inf"),
        (np.array([1e39]), "float32", 0.0, r"value at \(0,\) must be finite, got inf"),
        (np.array([1.5]), "int32", 0.0, "type must be int32, got float64"),
        (np.array([1]), "bool", 0.0, "type must be bool, got int64"),
        (np.array([1]), "int16", QUANTUM, "type must be float32 or float64 for fixed point, got int64"),
        (np.array(["x"]), "any", 0.0, "type must be bool, integer, float32 or float64"),
    ],
)
def test_values_that_cannot_be_stored_are_refused(values: np.ndarray, dtype: str, quantum: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        codec.encode(values, dtype, quantum)


def test_32_bits_hold_what_16_do_not() -> None:
    values = np.array([123.45678, -9.0])
    decoded = codec.decode(codec.encode(values, "int32", QUANTUM), QUANTUM)
    np.testing.assert_allclose(decoded, values, atol=QUANTUM)
