"""Pictures as files: PNG with its description inside, small, and the same bytes for the same picture."""

from pathlib import Path

from jaxtyping import UInt8
from numpy import ndarray
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from stylephase.errors import InputError
from stylephase.files import replacing

LIMIT = 500_000
# Above this a picture is reduced to so many colours, which makes it a third: notebooks hold many pictures.
_FULL_COLOUR, _COLOURS = 40_000, 128


def write_png(path: str | Path, pixels: UInt8[ndarray, "height width 3"], *, alt: str) -> None:
    """Write a picture with `alt`, what it shows in words, as its `Description`.

    A picture above 40 kB is reduced to 128 colours. Raises InputError where there is no description, where the name
    does not end in .png, and where the picture is above 500 kB all the same.
    """
    if Path(path).suffix != ".png":
        raise InputError("a picture's name should end in .png", path)
    if not alt.strip():
        raise InputError("a picture needs a description for those who cannot see it", path)
    info = PngInfo()
    info.add_itxt("Description", alt)
    picture = Image.fromarray(pixels)
    with replacing(path) as temporary:
        picture.save(temporary, pnginfo=info, optimize=True)
        if temporary.stat().st_size > _FULL_COLOUR:
            picture.quantize(_COLOURS, dither=Image.Dither.NONE).save(temporary, pnginfo=info, optimize=True)
        if temporary.stat().st_size > LIMIT:
            raise InputError(f"the picture takes {temporary.stat().st_size} bytes, more than {LIMIT}", path)
