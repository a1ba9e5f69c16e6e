"""What came of the claims on the played character ([M22] 4.4, Figure 1), and of our own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from numpy import ndarray

from stylephase.evaluation.comparison import mean_with_interval
from stylephase.evaluation.crowd import MOST, Crowd, FromOneClip, Recognised
from stylephase.evaluation.looks import Arms, Looks
from stylephase.evaluation.robustness import Endurance
from stylephase.evaluation.steered import ANGLE, NEAR, Aside, Blend
from stylephase.report.recorder import Recorder

# A jolt is this many times the largest acceleration without.
JOLT = 1.5


@dataclass(frozen=True)
class Found:
    """What the notebook measured, for its claims; `gaits` are speeds that were reached, and all, by gait."""

    dataset: str
    recorded: Float[ndarray, " styles"]
    looks: Mapping[str, Looks]
    pure: Arms
    half: Arms
    more_wrong: tuple[float, float, float]
    mixing: Float[ndarray, "triples 3"]
    costs: Mapping[str, float]
    wanted: Float[ndarray, " styles"]
    led: Float[ndarray, " styles"]
    gaits: Mapping[str, tuple[int, int]]
    aside: Sequence[Aside]
    endured: Sequence[Endurance]
    alone: Sequence[Endurance]
    one_clip: FromOneClip | None
    blend: Blend
    recognised: Recognised
    crowd: Crowd
    released: bool
    seconds: float


def record(recorder: Recorder, found: Found) -> None:
    """The claims of [M22] 4.4 and Figure 1 and of our own that this notebook can judge."""
    _record_blend(recorder, found.blend)
    _record_crowd(recorder, found)
    _record_finishing(recorder, found)
    _record_mixing(recorder, found)
    _record_codes(recorder, found)
    near = np.abs(found.led / found.wanted - 1) <= NEAR
    off = f"the farthest off goes at {np.abs(found.led / found.wanted - 1).max():.0%} more or less than asked"
    recorder.claim("ours-play-speeds", value=float(near.mean()), n=len(near), note=off)
    note = ", ".join(f"{gait} {reached} of {count}" for gait, (reached, count) in found.gaits.items())
    reached, count = np.sum(list(found.gaits.values()), axis=0).tolist()
    recorder.claim("ours-play-gaits", value=reached / count, n=count, note=note)
    _record_aside(recorder, found.aside)
    held = sum(not e.broken for e in found.endured)
    note = f"for {found.seconds:g} s each; {_broken(found)}"
    recorder.claim("ours-play-endurance", value=held / len(found.endured), n=len(found.endured), note=note)
    seen = found.recognised
    note = f"{seen.right} of {seen.count}, {seen.dealt} with each other's codes"
    recorder.claim("ours-play-crowd-recognised", value=seen.right / seen.count, n=seen.count, note=note)


def _record_aside(recorder: Recorder, aside: Sequence[Aside]) -> None:
    if not aside:
        recorder.not_testable("ours-play-aside", "takes that go aside or backward")
        return
    share, ahead = (float(np.mean([getattr(one, part) for one in aside])) for part in ("reached", "by_chance"))
    note = f"led straight ahead {ahead:.2f}; an angle within {np.degrees(ANGLE):.0f} degrees, a speed within 10 %"
    recorder.claim("ours-play-aside", value=share, n=len(aside), note=note)


def _record_blend(recorder: Recorder, blend: Blend) -> None:
    user, network = ([round(float(part[at]), 3) for at in (0, -1)] for part in (blend.user, blend.network))
    note = f"share of the wish {user[0]:.2f} at the next point and {user[1]:.2f} at the last, of the network's path "
    note += f"{network[0]:.2f} and {network[1]:.2f}; turns of 90 degrees end {blend.turned.mean():.0f} degrees off, "
    note += f"with the wish left out {blend.unheard.mean():.0f}"
    recorder.claim("m22-demo-trajectory-blend", blend.blended, note, value=user, n=len(blend.turned))


def _record_crowd(recorder: Recorder, found: Found) -> None:
    crowd = found.crowd
    whose = "the authors' network" if found.released else "our network"
    note = f"of {crowd.count} styles of {whose} {crowd.right} are told apart: nearest to other walks of their own, "
    note += f"{crowd.dealt} where styles are dealt anew; not held against recorded walks"
    dataset = "100style" if found.released else None
    recorder.claim("m22-fig1-many-styles", crowd.most, note, value=crowd.right, n=crowd.count, dataset=dataset)


def _record_finishing(recorder: Recorder, found: Found) -> None:
    skate = {name: looks.skate for name, looks in found.looks.items()}
    value, low, high = effect(skate["grounded"] - skate["finished"])
    better = low > 0 and (skate["scrambled"] > skate["raw"]).mean() > 0.5
    note = f"holding feet lessens the slide by {value:.3f} m/s [{low:.3f}, {high:.3f}] over {len(found.recorded)} "
    note += f"styles, from {np.median(skate['grounded']):.3f} grounded ({np.median(skate['raw']):.3f} raw) to "
    note += f"{np.median(skate['finished']):.4f}; feet held at wrong times slide {np.median(skate['scrambled']):.2f}"
    recorder.claim("m22-demo-foot-ik", bool(better), note, value=float(np.median(skate["finished"])))
    value, low, high = found.more_wrong
    share = [100 * float(part.mean()) for part in (found.pure.wrong, found.half.wrong, found.half.wrong_led)]
    note = f"a hand over 5 cm off in {share[1]:.1f} % of frames of interpolated styles by rotations alone, in "
    note += f"{share[0]:.1f} % of pure ones (difference {100 * value:.1f} [{100 * low:.1f}, {100 * high:.1f}]), "
    note += f"and in {share[2]:.1f} % with led arms"
    mended = low > 0 and share[2] < 0.2 * share[1]
    recorder.claim("m22-demo-arm-ik", mended, note, value=share[1:])
    finished = found.looks["finished"]
    jerks, costs = finished.acceleration / found.recorded, found.costs
    median = f"{np.median(finished.skate):.4f} m/s in the median"
    recorder.claim("ours-play-skate", value=float(finished.skate.max()), n=len(jerks), note=median)
    median = f"{np.median(jerks):.2f} times the recorded in the median"
    recorder.claim("ours-play-pops", value=float(jerks.max()), n=len(jerks), note=median)
    before = f"{found.looks['raw'].bones.max():.0f} mm before"
    recorder.claim("ours-play-bones", value=float(finished.bones.max()), note=before)
    parts = f"{costs['finishing']:.2f} ms beside {costs['network']:.2f} ms of the network"
    recorder.claim("ours-play-finishing-cost", value=costs["finishing"] / costs["network"], note=parts)


def _record_mixing(recorder: Recorder, found: Found) -> None:
    changing, held, jumping = np.log(found.mixing).T
    (value, _, high), (null, low, _) = (np.exp(effect(part)) for part in (changing - held, jumping - changing))
    smooth = bool(high <= JOLT and low > 1)
    note = f"largest acceleration {value:.2f} times that of held mixtures (at most {high:.2f}); where the mixture "
    note += f"jumps {null:.2f} times as much again (at least {low:.2f}); {len(held)} triangles"
    recorder.claim("m22-demo-three-styles", smooth, note, value=smooth)


def _record_codes(recorder: Recorder, found: Found) -> None:
    ways = {"a stored mean of clips": (found.alone, found.recognised)}
    if found.one_clip is not None:
        name = f"the code of one clip ({found.one_clip.weights})"
        ways |= {name: (found.one_clip.endured, found.one_clip.recognised)}
    kept = [sum(not e.broken for e in endured) for endured, _ in ways.values()]
    n, notes = len(found.alone), []
    for held, (way, (endured, seen)) in zip(kept, ways.items(), strict=True):
        after = max(e.after for e in endured)
        note = f"from {way} {seen.right} of {n} styles are nearest to their own, {seen.dealt} with each other's codes"
        notes.append(f"{note}; {held} stay plausible for {after:.0f} s")
    good = all(held >= MOST * n and seen.most for held, (_, seen) in zip(kept, ways.values(), strict=True))
    recorder.claim("m22-demo-precomputed-code", good, "; ".join(notes), value=kept, n=n)
    if found.one_clip is None:
        recorder.not_testable("m22-arbitrary-length", "the style network, which the weights kept here leave out")
        return
    # Motion of any length: whoever breaks speaks against it.
    recorder.claim("m22-arbitrary-length", kept[-1] == n, notes[-1], value=kept[-1], n=n)


def _broken(found: Found) -> str:
    broken = [f"{e.style} {e.broken} after {e.after:.0f} s" for e in found.endured if e.broken]
    return "; ".join(broken) or "none broke"


def effect(values: Float[ndarray, " cases"], seed: int = 0) -> tuple[float, float, float]:
    """Mean over styles or pairs, and the interval when they are drawn again."""
    return mean_with_interval(values[None], np.random.default_rng(seed))
