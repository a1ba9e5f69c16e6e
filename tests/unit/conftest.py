"""Skeletons as they are met in the field, and takes to test the vectors with."""

import tarfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stylephase.motion.bvh import read_bvh
from stylephase.motion.clip import Clip, resample
from stylephase.motion.rotations import from_matrix, to_matrix
from stylephase.motion.skeleton import Skeleton
from stylephase.motion.synthetic import find_style, walk

# One joint a line, indented by its depth, with its offset (m) from its parent; round numbers, real names and trees.
# Names that end in Site are end sites.
TREES = {
    "100style": """
        Hips 0 0 0
          Chest 0 .12 0
            Chest2 0 .1 0
              Chest3 0 .1 0
                Chest4 0 .1 0
                  Neck 0 .14 0
                    Head 0 .09 0
                      HeadSite 0 .17 0
                  RightCollar -.03 .08 0
                    RightShoulder -.16 0 0
                      RightElbow -.3 0 0
                        RightWrist -.25 0 0
                          RightWristSite -.19 0 0
                  LeftCollar .03 .08 0
                    LeftShoulder .16 0 0
                      LeftElbow .3 0 0
                        LeftWrist .25 0 0
                          LeftWristSite .19 0 0
          RightHip -.1 0 0
            RightKnee 0 -.43 0
              RightAnkle 0 -.43 0
                RightToe 0 -.1 .19
                  RightToeSite 0 -.01 .05
          LeftHip .1 0 0
            LeftKnee 0 -.43 0
              LeftAnkle 0 -.43 0
                LeftToe 0 -.1 .19
                  LeftToeSite 0 -.01 .05
    """,
    # Frames along the bones, left limbs along +x, right limbs along -x; sites that lie on their joints.
    "bandai-namco": """
        Hips 0 0 0
          Spine .16 0 0
            Chest .09 0 0
              Neck .16 0 0
                Head .06 0 0
                  HeadSite 0 0 0
              Shoulder_L .13 0 .05
                UpperArm_L .05 0 0
                  LowerArm_L .24 0 0
                    Hand_L .22 0 0
                      Hand_LSite 0 0 0
              Shoulder_R .13 0 -.05
                UpperArm_R -.05 0 0
                  LowerArm_R -.24 0 0
                    Hand_R -.22 0 0
                      Hand_RSite 0 0 0
          UpperLeg_L -.02 -.06 0
            LowerLeg_L .39 0 0
              Foot_L .41 0 0
                Toes_L .12 0 0
                  Toes_LSite 0 0 0
          UpperLeg_R -.02 .06 0
            LowerLeg_R -.39 0 0
              Foot_R -.41 0 0
                Toes_R -.12 0 0
                  Toes_RSite 0 0 0
    """,
    # Bones of no length at the hips, legs spread, fingers and thumbs beyond the hands.
    "cmu": """
        Hips 0 0 0
          LHipJoint 0 0 0
            LeftUpLeg .08 -.1 .05
              LeftLeg .14 -.38 0
                LeftFoot .14 -.4 0
                  LeftToeBase .01 -.02 .13
                    LeftToeBaseSite 0 0 0
          RHipJoint 0 0 0
            RightUpLeg -.08 -.1 .05
              RightLeg -.14 -.38 0
                RightFoot -.14 -.4 0
                  RightToeBase -.01 -.02 .13
                    RightToeBaseSite 0 0 0
          LowerBack 0 0 0
            Spine 0 .12 -.01
              Spine1 0 .12 0
                Neck 0 0 0
                  Head 0 .1 .01
                LeftShoulder 0 0 0
                  LeftArm .19 .07 -.02
                    LeftForeArm .28 0 0
                      LeftHand .2 0 0
                        LeftFingerBase 0 0 0
                          LeftHandIndex1 .04 0 0
                            LeftHandIndex1Site 0 0 0
                        LThumb 0 0 0
                          LThumbSite 0 0 0
                RightShoulder 0 0 0
                  RightArm -.19 .07 -.02
                    RightForeArm -.28 0 0
                      RightHand -.2 0 0
                        RightFingerBase 0 0 0
                          RightHandIndex1 -.04 0 0
                            RightHandIndex1Site 0 0 0
                        RThumb 0 0 0
                          RThumbSite 0 0 0
    """,
    # A prefix before every name, finger joints that are called hands, two joints at each toe.
    "mixamo": """
        mixamorig:Hips 0 0 0
          mixamorig:Spine 0 .1 0
            mixamorig:Spine1 0 .12 0
              mixamorig:Head 0 .3 0
              mixamorig:LeftShoulder .06 .1 0
                mixamorig:LeftArm .12 0 0
                  mixamorig:LeftForeArm .27 0 0
                    mixamorig:LeftHand .27 0 0
                      mixamorig:LeftHandThumb1 .03 0 .03
                        mixamorig:LeftHandThumb2 .04 0 0
                      mixamorig:LeftHandMiddle1 .1 0 0
                        mixamorig:LeftHandMiddle2 .03 0 0
              mixamorig:RightShoulder -.06 .1 0
                mixamorig:RightArm -.12 0 0
                  mixamorig:RightForeArm -.27 0 0
                    mixamorig:RightHand -.27 0 0
                      mixamorig:RightHandThumb1 -.03 0 .03
                        mixamorig:RightHandThumb2 -.04 0 0
                      mixamorig:RightHandMiddle1 -.1 0 0
                        mixamorig:RightHandMiddle2 -.03 0 0
          mixamorig:LeftUpLeg .09 -.05 0
            mixamorig:LeftLeg 0 -.42 0
              mixamorig:LeftFoot 0 -.42 0
                mixamorig:LeftToeBase 0 -.08 .12
                  mixamorig:LeftToe_End 0 0 .08
          mixamorig:RightUpLeg -.09 -.05 0
            mixamorig:RightLeg 0 -.42 0
              mixamorig:RightFoot 0 -.42 0
                mixamorig:RightToeBase 0 -.08 .12
                  mixamorig:RightToe_End 0 0 .08
    """,
    # Sides by a small letter in front, feet without toes, hands with end sites.
    "poser": """
        hip 0 0 0
          chest 0 .3 0
            lCollar .05 .1 0
              lForeArm .4 0 0
                lHand .25 0 0
                  lHandSite .1 0 0
            rCollar -.05 .1 0
              rForeArm -.4 0 0
                rHand -.25 0 0
                  rHandSite -.1 0 0
          lThigh .1 -.05 0
            lShin 0 -.42 0
              lFoot 0 -.42 0
                lFootSite 0 -.05 .1
          rThigh -.1 -.05 0
            rShin 0 -.42 0
              rFoot 0 -.42 0
                rFootSite 0 -.05 .1
    """,
}


def parsed(text: str) -> Skeleton:
    names, depths, parents, offsets = list[str](), list[int](), list[int](), list[list[float]]()
    for line in filter(str.strip, text.splitlines()):
        name, *numbers = line.split()
        depth = len(line) - len(line.lstrip())
        above = [j for j, other in enumerate(depths) if other < depth]
        names.append(name)
        parents.append(above[-1] if above else -1)
        depths.append(depth)
        offsets.append([float(number) for number in numbers])
    return Skeleton(tuple(names), tuple(parents), np.array(offsets), tuple(name.endswith("Site") for name in names))


@pytest.fixture(scope="session")
def skeletons() -> dict[str, Skeleton]:
    """Skeletons of several origins by name."""
    return {name: parsed(text) for name, text in TREES.items()}


@pytest.fixture(scope="session")
def limping() -> Clip:
    """Three seconds of the synthetic walker with one leg dragged, along a bent path: no symmetry to hide behind."""
    clip, truth = walk(find_style("DraggedLeft"), "FW", seconds=3.0)
    return clip.frames(*truth.cut)


@pytest.fixture(scope="session")
def upright() -> Clip:
    """Two seconds of the synthetic walker without any style."""
    clip, truth = walk(find_style("Plain"), "FW", seconds=2.0)
    return clip.frames(*truth.cut)


def odd_frames(skeleton: Skeleton) -> np.ndarray:
    """A change of axes for each joint, any of the 24 that there are; an end site has that of its joint."""
    number = np.random.default_rng(4).integers(24, size=len(skeleton))
    number = np.where(skeleton.sites, number[list(skeleton.parents)], number)
    return Rotation.create_group("O").as_matrix()[number]


def reframed(clip: Clip) -> Clip:
    """The same motion with each joint's axes laid another way (`odd_frames`), as other riggers would have laid them."""
    skeleton, change = clip.skeleton, odd_frames(clip.skeleton)
    above = np.concatenate([np.eye(3)[None], change[list(skeleton.parents[1:])]])
    local = np.swapaxes(above, 1, 2) @ to_matrix(clip.rotations) @ change
    offsets = np.einsum("jba,jb->ja", above, skeleton.offsets)
    return replace(clip, skeleton=replace(skeleton, offsets=offsets), rotations=from_matrix(local))


def mirrored(clip: Clip) -> Clip:
    """The mirror image of a clip whose joint frames stand upright: x changes its sign, left and right swap."""
    rotations = clip.rotations[:, clip.skeleton.mirrored] * [1, 1, -1, -1]
    return replace(clip, rotations=rotations, root_positions=clip.root_positions * [-1, 1, 1])


def moved(clip: Clip, angle: float, x: float, z: float) -> Clip:
    """The whole take turned about the origin by `angle` (rad, to the left), then moved over the ground."""
    world = Rotation.from_euler("y", angle)
    hips = world * Rotation.from_quat(clip.rotations[:, 0], scalar_first=True)
    rotations = np.concatenate([hips.as_quat(scalar_first=True)[:, None], clip.rotations[:, 1:]], axis=1)
    return replace(clip, rotations=rotations, root_positions=world.apply(clip.root_positions) + np.array([x, 0.0, z]))


@pytest.fixture(scope="session")
def change() -> SimpleNamespace:
    """What may be done to a clip as a whole: `mirrored`, `moved`, `reframed`; and `odd_frames` of a skeleton."""
    return SimpleNamespace(mirrored=mirrored, moved=moved, reframed=reframed, odd_frames=odd_frames)


@pytest.fixture(scope="session")
def real_file(mirror: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """A function that takes one file out of an archive of real data, by archive and the end of its name."""

    def take(archive: str, ending: str) -> Path:
        with tarfile.open(mirror / archive, "r|xz") as members:
            member = next(m for m in members if m.name.endswith(ending))
            path = tmp_path_factory.mktemp("real") / Path(member.name).name
            content = members.extractfile(member)
            assert content is not None
            path.write_bytes(content.read())
        return path

    return take


@pytest.fixture(scope="session")
def real_take(real_file) -> Clip:
    """A real take whose joint frames lie along the bones, opposite ways on both sides, at 60 frames a second."""
    path = real_file("bandai-namco-locomotion.tar.xz", "dataset-1_walk-left_tired_001.bvh")
    return resample(read_bvh(path, metres_per_unit=0.01), 60.0)
