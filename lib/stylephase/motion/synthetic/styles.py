"""The walker's styles: a table of parameters, each style with the difficulty it carries."""

from dataclasses import dataclass

from stylephase.errors import InputError


@dataclass(frozen=True)
class Arm:
    """An arm's pose and its swing (rad).

    Angles count from an arm that hangs down, thumb forward: `flex` raises it to the front, `abduct` to the side,
    `twist` turns the forearm inwards, `elbow` bends. `swing` and `bend` are the amplitudes of flex and elbow.
    """

    flex: float = -0.02
    abduct: float = 0.12
    twist: float = 0.12
    elbow: float = 0.35
    swing: float = 0.36
    bend: float = 0.2


@dataclass(frozen=True)
class WalkStyle:
    """One style. Lengths in m, angles in rad, times in s; amplitudes hold at the style's own walking speed."""

    name: str
    description: str
    # Pace: forward speed and the length of a cycle of two steps (one hop), walking and running.
    speed: float = 1.2
    cycle: float = 1.08
    run_speed: float = 2.6
    run_cycle: float = 0.72
    turn: float = 0.7
    # Posture: hips lowered, trunk bent forward, head raised against level gaze, shoulders' rise.
    crouch: float = 0.01
    lean: float = 0.04
    gaze: float = 0.0
    shrug: float = 0.0
    # Feet: half the distance between them, toes outwards, share of the cycle on the floor, clearance in the swing,
    # pitch at landing and at push-off.
    half_width: float = 0.07
    toe_out: float = 0.12
    duty: float = 0.62
    rise: float = 0.042
    land: float = 0.32
    push: float = 0.75
    # Hips: vertical and sideways amplitude, yaw and list; the chest turns against the hips.
    bounce: float = 0.01
    sway: float = 0.02
    pelvis_yaw: float = 0.08
    pelvis_list: float = 0.05
    chest_twist: float = 0.16
    # Arms: their pose, that of the left one where it differs, and the length of their cycle where it is their own.
    arms: Arm = Arm()
    left_arm: Arm | None = None
    arm_period: float | None = None
    # Sides and chance.
    hop: str | None = None
    drag: str | None = None
    glances: float = 0.0

    @property
    def symmetric(self) -> bool:
        """Whether left and right do the same half a cycle apart."""
        return self.hop is None and self.drag is None and self.left_arm is None

    @property
    def stochastic(self) -> bool:
        """Whether the style holds movements that do not come back with the cycle."""
        return self.glances > 0


STYLES = (
    WalkStyle("Plain", "An ordinary upright walk, against which the others are measured."),
    WalkStyle(
        "StoopedOver",
        "Trunk bent far forward, slow short steps: posture changes while the cycle grows to about 95 frames.",
        speed=0.7, cycle=1.55, turn=0.45, run_speed=1.7, run_cycle=0.85, lean=0.75, gaze=0.1, crouch=0.05, land=0.2,
        push=0.5, half_width=0.085, bounce=0.01, sway=0.03, duty=0.66,
        arms=Arm(flex=0.1, abduct=0.1, elbow=0.5, swing=0.18, bend=0.1),
    ),
    WalkStyle(
        "LowCrouch",
        "Knees bent deep throughout: the hips stay 20 cm low, so leg angles lie far from the other styles'.",
        speed=0.95, cycle=1.0, run_speed=2.1, crouch=0.22, lean=0.4, half_width=0.1, land=0.12, push=0.5, rise=0.045,
        arms=Arm(flex=0.3, abduct=0.25, elbow=0.9, swing=0.2, bend=0.15),
    ),
    WalkStyle(
        "ChestOut",
        "Trunk leant back, chin up, brisk wide-swinging arms: a small change of posture that must still tell.",
        speed=1.35, cycle=1.0, run_speed=2.7, lean=-0.16, gaze=0.2, shrug=0.06, push=0.8, pelvis_yaw=0.12,
        chest_twist=0.24, bounce=0.015, arms=Arm(flex=-0.15, abduct=0.28, elbow=0.35, swing=0.55, bend=0.25),
    ),
    WalkStyle(
        "Sleepwalk",
        "Both arms stretched out in front and nearly still, stiff low steps: hands far from where they hang.",
        speed=0.75, cycle=1.25, turn=0.5, run_speed=1.8, run_cycle=0.8, lean=-0.03, gaze=-0.12, land=0.1, push=0.4,
        rise=0.035, half_width=0.09, sway=0.045, pelvis_list=0.08, chest_twist=0.05,
        arms=Arm(flex=1.45, abduct=0.06, twist=0.9, elbow=0.12, swing=0.05, bend=0.03),
    ),
    WalkStyle(
        "DraggedLeft",
        "The left leg is dragged, toes out, and carries for a short time only: the two sides differ in time and shape.",
        speed=0.65, cycle=1.3, turn=0.45, run_speed=1.3, run_cycle=0.9, lean=0.12, sway=0.035, bounce=0.02, drag="left",
        half_width=0.085, pelvis_yaw=0.1,
        left_arm=Arm(flex=0.35, abduct=0.25, twist=0.8, elbow=1.1, swing=0.12, bend=0.08),
    ),
    WalkStyle(
        "HopOnRight",
        "Hops on the right foot while the left never touches the floor: one foot has no contact to take a phase from.",
        speed=0.9, cycle=0.56, run_speed=1.6, run_cycle=0.5, lean=0.12, crouch=0.05, half_width=0.03, duty=0.5,
        rise=0.06, land=-0.15, push=0.55, toe_out=0.03, sway=0.0, pelvis_yaw=0.0, pelvis_list=0.0, chest_twist=0.03,
        hop="right", arms=Arm(flex=0.25, abduct=0.45, elbow=0.9, swing=0.25, bend=0.2),
    ),
    WalkStyle(
        "OffbeatArms",
        "The arms keep a beat of their own, 0.78 s, whatever the feet do: no single global phase describes the body.",
        arm_period=0.78, speed=1.0, cycle=1.15, chest_twist=0.08,
        arms=Arm(flex=0.35, abduct=0.2, elbow=0.8, swing=0.6, bend=0.35),
    ),
    WalkStyle(
        "PocketHands",
        "Hands kept in the pockets: they hardly move against the hips, so their phase hangs on millimetres.",
        speed=1.05, cycle=1.12, lean=0.1, gaze=-0.12, shrug=0.1, chest_twist=0.06,
        arms=Arm(flex=-0.42, abduct=0.28, twist=0.75, elbow=0.95, swing=0.025, bend=0.015),
    ),
    WalkStyle(
        "GlancingBack",
        "Walks on while looking over a shoulder at random moments: movement that no phase explains.",
        speed=1.15, cycle=1.0, lean=0.1, crouch=0.03, glances=0.3,
        arms=Arm(flex=0.05, elbow=0.6, swing=0.3, bend=0.2),
    ),
    WalkStyle(
        "SlowProcession",
        "Solemn steps with cycles of about 130 frames: longer than the usual windows of phase extraction.",
        speed=0.5, cycle=2.15, turn=0.3, run_speed=1.5, run_cycle=0.95, gaze=0.05, lean=0.0, land=0.22, push=0.55,
        sway=0.03, duty=0.66, rise=0.05, bounce=0.012, arms=Arm(flex=0.05, elbow=0.25, swing=0.2, bend=0.08),
    ),
    WalkStyle(
        "QuickShuffle",
        "Tiny flat steps with cycles of about 36 frames, elbows bent: fast events with little movement.",
        speed=0.75, cycle=0.6, run_speed=1.6, run_cycle=0.5, turn=0.9, lean=0.15, crouch=0.04, land=0.06, push=0.25,
        rise=0.035, bounce=0.006, sway=0.01, half_width=0.06, pelvis_yaw=0.04, pelvis_list=0.03, chest_twist=0.08,
        arms=Arm(flex=-0.1, abduct=0.15, elbow=1.35, swing=0.2, bend=0.1),
    ),
    WalkStyle(
        "GiantStrides",
        "Strides as long as the legs allow, hips dipping at every step: the largest movements of all.",
        speed=1.55, cycle=1.3, run_speed=3.0, run_cycle=0.82, crouch=0.03, lean=0.1, push=0.8, land=0.4, rise=0.08,
        duty=0.58, bounce=0.01, pelvis_yaw=0.15, chest_twist=0.24, sway=0.025,
        arms=Arm(flex=0.05, elbow=0.4, swing=0.75, bend=0.35),
    ),
    WalkStyle(
        "KneesUp",
        "Marches with the thighs raised level and forearms bent: legs move most where other feet just clear the floor.",
        speed=0.9, cycle=1.05, run_speed=1.8, run_cycle=0.7, lean=-0.04, rise=0.29, land=-0.1, push=0.6, duty=0.57,
        chest_twist=0.1, arms=Arm(flex=0.1, elbow=0.9, swing=0.6, bend=0.25),
    ),
)  # fmt: skip


def find_style(name: str) -> WalkStyle:
    """The style called `name`; raises InputError with the names there are."""
    for style in STYLES:
        if style.name == name:
            return style
    raise InputError(f"no synthetic style {name!r}; there are {', '.join(style.name for style in STYLES)}")
