"""What stands in front of the camera in a made film."""

from __future__ import annotations

from dataclasses import dataclass, replace

from measure.geometry.camera import Camera


@dataclass(frozen=True)
class MadeMark:
    """A square mark on the perimeter.

    azimuth_rad : about the vertical, zero towards the camera, positive to the right. height_m : of its centre above
    the platform's origin. size_m : its side. kind : speckle, quadrant or dot. grain_m : radius of a speckle.
    """

    azimuth_rad: float
    height_m: float
    size_m: float
    kind: str = "speckle"
    grain_m: float = 0.0012


@dataclass(frozen=True)
class Rod:
    """A thin thing between camera and platform that does not move: a straight strip of the picture, px."""

    x1: float
    y1: float
    x2: float
    y2: float
    width: float
    grey: float = 0.15


@dataclass(frozen=True)
class Scene:
    """What stands in front of the camera, and the camera.

    width, height : px. radius_m, half_height_m : the platform's cylinder about its origin. exposure_s : time over
    which a picture is collected, centred on the frame's time. light : brightness at the end of the film over that at
    its start. light_gradient : change of brightness from the left to the right border, over the mean. noise : standard
    deviation, in grey levels of 8 bit. bits : 8, 12 or 16. rays : per pixel along each side. Albedos from 0 to 1.
    """

    width: int
    height: int
    camera: Camera
    marks: tuple[MadeMark, ...]
    radius_m: float
    half_height_m: float
    rods: tuple[Rod, ...] = ()
    exposure_s: float = 0.0
    light: float = 1.0
    light_gradient: float = 0.0
    noise: float = 1.5
    bits: int = 8
    rays: int = 3
    background: float = 0.25
    body: float = 0.6


def deployment_scene(**changed) -> Scene:
    """The rig as the shipped film shows it: six speckled marks in two rows, two rods in front, half a millimetre to the pixel.

    The platform starts at the bottom of the picture and has room to rise by 450 mm. The background is a black cloth
    under the camera's black level, which keeps the film small. changed : fields of `Scene` that shall differ.
    """
    camera = Camera(0.5e-3, (152.0, 962.0), 0.0, 3.0, (152.0, 512.0))
    marks = tuple(MadeMark(azimuth, height, 0.017) for height in (-0.0115, 0.0115) for azimuth in (-0.55, 0.0, 0.55))
    rods = (Rod(112.0, 0.0, 115.0, 1023.0, 4.0), Rod(190.0, 0.0, 187.0, 1023.0, 4.0))
    scene = Scene(
        304, 1024, camera, marks, radius_m=0.07, half_height_m=0.0235, rods=rods, exposure_s=0.2e-3, noise=1.0, background=-0.012
    )  # fmt: skip
    return replace(scene, **changed)
