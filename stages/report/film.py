"""Short videos that any browser plays: H.264 in MP4, with equal bytes for equal pictures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[np.uint8]

# One thread and "bitexact": no version, date or thread-dependent decision gets into the file. Colours are declared,
# or browsers guess the matrix from the height of the picture.
COLOURS = {"colorspace": "bt709", "color_primaries": "bt709", "color_trc": "bt709"}
ENCODER = {"preset": "medium", "crf": "21", "threads": "1", "movflags": "+faststart"}
EXACT = {"fflags": "+bitexact", "flags:v": "+bitexact", "map_metadata": "-1"}
OPTIONS = {"vf": "scale=out_color_matrix=bt709:out_range=tv", **COLOURS, **ENCODER, **EXACT}


def write_film(path: Path, pictures: Iterable[Picture], width: int, height: int, fps: float) -> int:
    """Writes pictures as a video.

    Args:
        path: File to write, ending in .mp4.
        pictures: Pictures, each of shape [height, width, 3].
        width: Width [px], even.
        height: Height [px], even.
        fps: Pictures per second.

    Returns:
        Number of pictures written.

    Raises:
        ValueError: A size is odd: H.264 in 4:2:0 stores colour for pairs of pixels.
    """
    if width % 2 or height % 2:
        raise ValueError(f"a video's width and height must be even, got {width} x {height} px")
    writer = imageio_ffmpeg.write_frames(
        str(path),
        (width, height),
        fps=fps,
        codec="libx264",
        pix_fmt_in="rgb24",
        pix_fmt_out="yuv420p",
        quality=None,
        macro_block_size=2,
        ffmpeg_log_level="error",
        output_params=[word for name, value in OPTIONS.items() for word in (f"-{name}", value)],
    )
    writer.send(None)
    count = 0
    try:
        for picture in pictures:
            writer.send(np.ascontiguousarray(picture))
            count += 1
    finally:
        writer.close()
    return count
