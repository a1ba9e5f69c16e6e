"""The colours of all figures: chosen to stay apart for readers with any of the three colour vision deficiencies.

Left is blue and right is orange everywhere: on the character, in its contacts and in the curves of its end effectors.
"""

LEFT, RIGHT, BODY = "#0072B2", "#D55E00", "#B4BAC3"
BACKGROUND, GROUND_LINE, SHADOW = "#FFFFFF", "#C3CAD3", "#E1E4E9"
INK, QUIET = "#222222", "#8A8F96"
# For things that are neither a side nor a model, such as styles; told apart by colour and by marker together.
SEQUENCE = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#7A7A7A")
HIGHLIGHT = "#C2185B"
CONTACT = "#4D9F5C"

# The feet take the colours of the legs, the hands a lighter tone of the same side.
EFFECTORS = {"LeftHand": "#56B4E9", "RightHand": "#F2B134", "LeftFoot": LEFT, "RightFoot": RIGHT}

# Hue says how style enters the network (grey: one-hot, orange: residual adapter, blue: FiLM); among networks of one
# hue a darker tone says local phases.
MODELS = {
    "pfnn-onehot": "#B8B8B8",
    "lpn-onehot": "#606060",
    "pfnn-resad": "#EFCB45",
    "lpn-resad": "#C4561A",
    "pfnn-film": "#7CC4F5",
    "mann-film": "#3F7FE0",
    "lpn-film": "#14246E",
}

# The adapters of [M18], and a mark for each of those that one picture compares.
ADAPTERS = {"full": "#D55E00", "diag": "#009E73", "cp": "#0072B2"}
ADAPTER_MARKS = {"CP": "o", "diagonal": "^", "full": "s", "CP, 3 factors": "D", "CP, 100 factors": "v"}

# What became of a claim, from reproduced to open; no colour of a side.
OUTCOMES = ("#004A41", "#70C8A4", "#E8A317", "#7C8189", "#EEF0F3")


def colour_of_adapter(name: str, otherwise: str = QUIET) -> str:
    """The colour of a kind of adapter by how its name begins (`CP on neutral`); `otherwise` for anything else."""
    return next((colour for kind, colour in ADAPTERS.items() if name.lower().startswith(kind)), otherwise)


def colour_of(name: str) -> str:
    """The colour of a model or end effector by its name; quiet grey for anything else, such as a naive predictor.

    What stands after a comma tells apart several things of one model (`lpn-film, training`), which share its hue.
    """
    model, comma, _ = name.partition(",")
    colour = MODELS.get(model) or EFFECTORS.get(model) or QUIET
    return lighter(colour, 0.45) if comma and colour != QUIET else colour


def dashes_of(name: str) -> str:
    """The line style of a model, to tell curves apart without colour: solid for local phases, dots after a comma."""
    return ":" if "," in name else {"pfnn": "--", "mann": "-.", "lpn": "-"}.get(name.split("-")[0], ":")


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue (0 to 255) of a colour written `#RRGGBB`."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def ink_on(colour: str) -> str:
    """The colour of letters that can be read on this one: ink on light tones, the background's on dark ones."""
    red, green, blue = rgb(colour)
    return INK if 0.3 * red + 0.6 * green + 0.1 * blue > 150 else BACKGROUND


def darker(colour: str, by: float = 0.2) -> str:
    """The colour mixed with black, `by` being the share of black."""
    return "#" + "".join(f"{round(channel * (1 - by)):02X}" for channel in rgb(colour))


def lighter(colour: str, by: float) -> str:
    """The colour mixed with white, `by` being the share of white."""
    return "#" + "".join(f"{round(channel + (255 - channel) * by):02X}" for channel in rgb(colour))
