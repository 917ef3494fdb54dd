"""Writes the files of this folder with the software that others write such files with.

The sample at x, y, z of channel c in frame t is x + 5 y + 7 z + 11 c + 13 t (minus 40 in signed types, plus 1/4 in
floating point). The name of a file describes its content: format, variant, number type, `rgb` for three channels, `t`
for two frames. Volumes have 5 x 4 x 3 voxels; where a format holds spacing, it is 0.5, 1.25, 2.

Needs numpy, nibabel, pynrrd, SimpleITK, tifffile, imagecodecs, Pillow and vtk. Run it in this folder.
"""

import os

import nibabel
import nrrd
import numpy as np
import SimpleITK as sitk
import tifffile
import vtk
from PIL import Image
from vtk.util.numpy_support import numpy_to_vtk

NAMES = {"u8": "u1", "i8": "i1", "u16": "u2", "i16": "i2", "u32": "u4", "i32": "i4", "u64": "u8", "i64": "i8",
         "f32": "f4", "f64": "f8"}
SPACING = (0.5, 1.25, 2.0)


def volume(name, rgb=False, frames=False):
    """Indexed [t, z, y, x, c]."""
    t, z, y, x, c = np.meshgrid(range(2 if frames else 1), range(3), range(4), range(5), range(3 if rgb else 1),
                                indexing="ij")
    n = x + 5 * y + 7 * z + 11 * c + 13 * t
    shift = {"u": 0, "i": -40, "f": 0.25}[name[0]]
    return (n + shift).astype(NAMES[name])


def scalars(name):
    return volume(name)[0, ..., 0]


def npy():
    for name in NAMES:
        np.save(f"npy-c-{name}.npy", scalars(name))
    np.save("npy-fortran-i16.npy", np.asfortranarray(scalars("i16")))
    np.save("npy-big-f64.npy", scalars("f64").astype(">f8"))
    np.save("npy-c-u8-t.npy", volume("u8", frames=True)[..., 0])
    np.save("npy-fortran-u8-t.npy", np.asfortranarray(volume("u8", frames=True)[..., 0]))
    np.save("npy-c-u8-rgb.npy", volume("u8", rgb=True)[0])
    np.save("npy-fortran-f32-rgb-t.npy", np.asfortranarray(volume("f32", rgb=True, frames=True)))


def nifti():
    affine = np.diag(SPACING + (1,))

    def save(path, data, header=None):
        header = header or nibabel.Nifti1Header()
        header.set_data_dtype(data.dtype)
        image = nibabel.Nifti1Image(data, affine, header)
        image.header.set_xyzt_units("mm", "sec")
        nibabel.save(image, path)

    for name in NAMES:
        save(f"nifti-{name}.nii", scalars(name).transpose(2, 1, 0))
    save("nifti-gz-i16-t.nii.gz", volume("i16", frames=True)[..., 0].transpose(3, 2, 1, 0))
    save("nifti-big-i16.nii", scalars("i16").transpose(2, 1, 0), nibabel.Nifti1Header(endianness=">"))
    # Vectors lie in the fifth axis, one component after another.
    vectors = volume("f32", rgb=True, frames=True).transpose(3, 2, 1, 0, 4)
    save("nifti-vector-f32-rgb-t.nii", vectors)
    colours = np.zeros((5, 4, 3), dtype=[("R", "u1"), ("G", "u1"), ("B", "u1")])
    for c, channel in enumerate("RGB"):
        colours[channel] = volume("u8", rgb=True)[0, ..., c].transpose(2, 1, 0)
    save("nifti-rgb24-u8-rgb.nii.gz", colours)
    header = nibabel.Nifti1Header()
    header.set_data_dtype("i2")
    image = nibabel.Nifti1Image(scalars("i16").transpose(2, 1, 0), affine, header)
    image.header.set_slope_inter(0.5, -3)
    # The numbers are stored as they are: read, they are (n - 40) / 2 - 3.
    nibabel.save(image, "scaled-i16.nii")


def images():
    for name in NAMES:
        tifffile.imwrite(f"tiff-plain-{name}.tif", scalars(name), photometric="minisblack")
    tifffile.imwrite("tiff-lzw-u16.tif", scalars("u16"), photometric="minisblack", compression="lzw", predictor=True)
    tifffile.imwrite("tiff-deflate-f32.tif", scalars("f32"), photometric="minisblack", compression="deflate")
    tifffile.imwrite("tiff-packbits-u8.tif", scalars("u8"), photometric="minisblack", compression="packbits")
    tifffile.imwrite("tiff-tiled-i32.tif", scalars("i32"), photometric="minisblack", tile=(16, 16))
    tifffile.imwrite("tiff-big-i16.tif", scalars("i16"), photometric="minisblack", byteorder=">")
    tifffile.imwrite("tiff-bigtiff-u8.tif", scalars("u8"), photometric="minisblack", bigtiff=True)
    tifffile.imwrite("tiff-plain-u8-rgb.tif", volume("u8", rgb=True)[0], photometric="rgb")
    for folder in ("png-u8", "png-u16", "png-u8-rgb", "tiff-slices-i16"):
        os.makedirs(folder, exist_ok=True)
    for z, number in enumerate((8, 9, 10)):
        Image.fromarray(scalars("u8")[z]).save(f"png-u8/slice{number}.png")
        Image.fromarray(scalars("u16")[z]).save(f"png-u16/{number}.png")
        Image.fromarray(volume("u8", rgb=True)[0, z]).save(f"png-u8-rgb/s-{number}.png")
        tifffile.imwrite(f"tiff-slices-i16/s{number}.tif", scalars("i16")[z], photometric="minisblack")


def vti():
    def save(path, name, rgb=False, cells=False, also=False, **settings):
        data = volume(name, rgb=rgb)[0]
        image = vtk.vtkImageData()
        image.SetDimensions(*((n + 1 for n in (5, 4, 3)) if cells else (5, 4, 3)))
        image.SetSpacing(*SPACING)
        image.SetOrigin(1, 2, 3)
        array = numpy_to_vtk(data.reshape(-1, data.shape[-1]), deep=True)
        array.SetName("density")
        attributes = image.GetCellData() if cells else image.GetPointData()
        if also:
            other = numpy_to_vtk(np.arange(60, dtype="f4"), deep=True)
            other.SetName("other")
            attributes.AddArray(other)
        attributes.SetScalars(array)
        writer = vtk.vtkXMLImageDataWriter()
        writer.SetFileName(path)
        writer.SetInputData(image)
        settings = {"mode": "Appended", "compress": True, "encode": True, "words": 64, "big": False, **settings}
        getattr(writer, f"SetDataModeTo{settings['mode']}")()
        writer.SetEncodeAppendedData(settings["encode"])
        if settings["compress"]:
            writer.SetCompressorTypeToZLib()
            writer.SetBlockSize(64)
        else:
            writer.SetCompressorTypeToNone()
        writer.SetHeaderType(settings["words"])
        if settings["big"]:
            writer.SetByteOrderToBigEndian()
        else:
            writer.SetByteOrderToLittleEndian()
        assert writer.Write() == 1, path

    for name in NAMES:
        save(f"vti-ascii-{name}.vti", name, mode="Ascii", compress=False)
    save("vti-base64-i16.vti", "i16", mode="Binary", compress=False)
    save("vti-base64zlib-f64.vti", "f64", mode="Binary")
    save("vti-base64zlib32big-u16.vti", "u16", mode="Binary", words=32, big=True)
    save("vti-appended64-u8.vti", "u8", compress=False)
    save("vti-appended64zlib-i32.vti", "i32", also=True)
    save("vti-appendedraw-u16.vti", "u16", compress=False, encode=False)
    save("vti-appendedraw32big-f32.vti", "f32", compress=False, encode=False, words=32, big=True)
    save("vti-appendedrawzlib-i64.vti", "i64", encode=False, also=True)
    save("vti-appendedrawzlibbig-u32.vti", "u32", encode=False, big=True)
    save("vti-cells-u8.vti", "u8", encode=False, cells=True)
    save("vti-appendedrawzlib-u8-rgb.vti", "u8", rgb=True, encode=False)


def headers():
    directions = np.diag(SPACING)
    for name in NAMES:
        nrrd.write(f"nrrd-{name}.nrrd", scalars(name).transpose(2, 1, 0), {"space directions": directions,
                                                                          "space": "left-posterior-superior"})
    nan = np.full((1, 3), np.nan)
    nrrd.write("nrrd-u8-rgb.nrrd", volume("u8", rgb=True)[0].transpose(3, 2, 1, 0),
               {"space directions": np.vstack([nan, directions]), "kinds": ["RGB-color"] + ["domain"] * 3,
                "space": "left-posterior-superior"})
    nrrd.write("nrrd-listfirst-u8-t.nrrd", volume("u8", frames=True)[..., 0].transpose(0, 3, 2, 1),
               {"space directions": np.vstack([nan, directions]), "kinds": ["list"] + ["domain"] * 3,
                "space": "left-posterior-superior"})
    nrrd.write("nrrd-f64-t.nrrd", volume("f64", frames=True)[..., 0].transpose(3, 2, 1, 0), {"spacings": SPACING + (3,)})
    for name in NAMES:
        image = sitk.GetImageFromArray(scalars(name))
        image.SetSpacing(SPACING)
        sitk.WriteImage(image, f"metaimage-{name}.mha", useCompression=True)
    image = sitk.GetImageFromArray(volume("f32", rgb=True)[0], isVector=True)
    image.SetSpacing(SPACING)
    sitk.WriteImage(image, "metaimage-f32-rgb.mha")
    image = sitk.GetImageFromArray(volume("i16", frames=True)[..., 0], isVector=False)
    image.SetSpacing(SPACING + (7.0,))
    sitk.WriteImage(image, "metaimage-i16-t.mha")


for write in (npy, nifti, images, vti, headers):
    write()
