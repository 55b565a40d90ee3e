"""The scene of a synthetic film: platform, marks, rods, camera, light and noise."""

from __future__ import annotations

from dataclasses import dataclass, replace

from measure.geometry.camera import Camera


@dataclass(frozen=True)
class MadeMark:
    """A square mark on the perimeter of the platform.

    Attributes
    ----------
    azimuth_rad : float
        About the vertical, zero towards the camera, positive to the right, rad.
    height_m : float
        Of its centre above the platform's origin, m.
    size_m : float
        Its side, m.
    kind : str
        speckle, quadrant or dot.
    grain_m : float
        Radius of a speckle, m.
    """

    azimuth_rad: float
    height_m: float
    size_m: float
    kind: str = "speckle"
    grain_m: float = 0.0012


@dataclass(frozen=True)
class Rod:
    """A thin object at rest between camera and platform: a straight strip of the picture, all in px; `grey` is its albedo, 0 to 1."""

    x1: float
    y1: float
    x2: float
    y2: float
    width: float
    grey: float = 0.15


@dataclass(frozen=True)
class Scene:
    """What is in front of the camera, and the camera.

    Attributes
    ----------
    width, height : int
        Of a picture, px.
    camera : Camera
    marks : tuple of MadeMark
    radius_m, half_height_m : float
        Of the platform's cylinder about its origin, m.
    rods : tuple of Rod
    exposure_s : float
        Exposure time, centred on the frame's time, s.
    readout_s : float
        Time from reading the first row of a picture to reading the last one, s; the middle row is read at the frame's time.
    light : float
        Brightness at the end of the film over that at its start.
    light_gradient : float
        Change of brightness from the left to the right border, over the mean.
    noise : float
        Standard deviation, in grey levels of 8 bit.
    bits : int
        8, 12 or 16.
    rays : int
        Per pixel along each side.
    background, body : float
        Albedos, 0 to 1.
    """

    width: int
    height: int
    camera: Camera
    marks: tuple[MadeMark, ...]
    radius_m: float
    half_height_m: float
    rods: tuple[Rod, ...] = ()
    exposure_s: float = 0.0
    readout_s: float = 0.0
    light: float = 1.0
    light_gradient: float = 0.0
    noise: float = 1.5
    bits: int = 8
    rays: int = 3
    background: float = 0.25
    body: float = 0.6


def deployment_scene(**changed) -> Scene:
    """The rig of the demonstration film: six speckled marks in two rows, two rods in front, 0.5 mm per pixel.

    The platform starts at the bottom of the picture and has room to rise by 450 mm. The background is a black cloth
    under the camera's black level, which keeps the file small.

    Parameters
    ----------
    **changed
        Fields of `Scene` that shall differ.

    Returns
    -------
    Scene
    """
    camera = Camera(0.5e-3, (152.0, 962.0), 0.0, 3.0, (152.0, 512.0))
    marks = tuple(MadeMark(azimuth, height, 0.017) for height in (-0.0115, 0.0115) for azimuth in (-0.55, 0.0, 0.55))
    rods = (Rod(112.0, 0.0, 115.0, 1023.0, 4.0), Rod(190.0, 0.0, 187.0, 1023.0, 4.0))
    scene = Scene(
        304, 1024, camera, marks, radius_m=0.07, half_height_m=0.0235, rods=rods, exposure_s=0.2e-3, noise=1.0, background=-0.012
    )  # fmt: skip
    return replace(scene, **changed)
