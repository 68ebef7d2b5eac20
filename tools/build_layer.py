"""Builds the garment layer that both genders of the free body share: `python -m tools.build_layer`.

Its reference is the mean of the two templates, so that neither gender's proportions decide where the vertices lie.
"""

from dataclasses import replace

import numpy as np

from model.body import load_free_body
from model.body.layer import FREE_LAYER, LayerTemplate, build_template, save_template


def free_template() -> LayerTemplate:
    """The layer of the free body."""
    female, male = load_free_body("female"), load_free_body("male")
    reference = 0.5 * (female.v_template.astype(np.float64) + male.v_template)
    joints = 0.5 * (female.joint_template + male.joint_template)
    weights = 0.5 * (female.weights + male.weights)
    return build_template(replace(female, weights=weights), reference, joints)


def main() -> None:
    """Writes the asset and says what it holds."""
    template = free_template()
    save_template(FREE_LAYER, template)
    print(f"{FREE_LAYER.name}: {len(template.corners)} vertices, {FREE_LAYER.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
