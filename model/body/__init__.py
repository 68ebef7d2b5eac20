"""Bodies in SMPL's schema, and the free body that comes with the project.

The model frame is y up: the T-pose faces +z, the left arm points along +x, units are metres. The world of the project
is z up. `pose` carries the turn between the two in its root rotation, as CLOTH3D's poses do, so that
`model.pose(betas, pose, trans)` is in the world directly, `trans` being the world position of the root joint. With
`REST_POSE` the root turns by +90 degrees about x: the person stands upright along +z, faces -y, and the left arm points
along +x.

The embedded body has the same meaning of betas for both genders: +beta_1 is taller and larger, +beta_2 is fatter,
beta_3 to beta_10 are the rest of human variation. One unit is one standard deviation among adults, less on the axes
whose ends would otherwise fold the skin, so that each axis is usable over [-3, 3]: stature 1.40-1.86 m (female) and
1.52-1.99 m (male) along beta_1, body mass index 17-28 and 17-31 kg/m^2 along beta_2.
"""

from model.body.asset import GENDERS, load_body, load_free_body, save_body
from model.body.model import BodyModel
from model.body.refusal import BodyFileError
from model.body.skeleton import JOINT_NAMES, PARENTS, REST_POSE
from model.body.skinning import joint_positions, joint_transforms, rotation_matrices, skin
from model.body.smpl_file import read_smpl

__all__ = [
    "GENDERS",
    "JOINT_NAMES",
    "PARENTS",
    "REST_POSE",
    "BodyFileError",
    "BodyModel",
    "joint_positions",
    "joint_transforms",
    "load_body",
    "load_free_body",
    "read_smpl",
    "rotation_matrices",
    "save_body",
    "skin",
]
