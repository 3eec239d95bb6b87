"""Mesh files as nobody should send them: mutations of sound ones, and lies made by hand."""

from __future__ import annotations

import base64
import io
import json
import warnings
import zipfile
import zlib
from pathlib import Path

import numpy as np

from data import folder as real_folder
from henkei.io import write
from written import EXACT, ROUNDED, encoded, patchwork, sheet

THROUGH_MESHIO = ("vtu", "msh", "inp", "mesh", "bdf")
REAL = ("cage/gel_head.obj", "cad-panel/plate_holes.stl", "nasty/featuretype_soup.ply")


def sound(scratch: Path) -> dict[str, bytes]:
    """Files in all formats, generated and real, by the name of each."""
    files = {
        f"{kind.replace(':', '-')}-{name}.{kind.partition(':')[0]}": encoded(kind, surface)
        for name, surface in (("patchwork", patchwork()), ("sheet", sheet()))
        for kind in (*EXACT, *ROUNDED)
    }
    for suffix in THROUGH_MESHIO:
        path = scratch / f"sheet.{suffix}"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            write(path, sheet())
        files[path.name] = path.read_bytes()
        path.unlink()
    for name in REAL:
        path = real_folder() / name
        if path.is_file():
            files[path.name] = path.read_bytes()
    return files


def mutated(data: bytes, seed: int) -> bytes:
    """Cut off, with a bit turned over, a number grown, a part lost, doubled or overwritten."""
    rng = np.random.default_rng(seed)
    damaged = bytearray(data)
    start = int(rng.integers(len(data)))
    end = start + int(rng.integers(1, 40))
    match seed % 6:
        case 0:
            del damaged[start:]
        case 1:
            damaged[start] ^= 1 << int(rng.integers(8))
        case 2:
            digits = [i for i, byte in enumerate(data) if 48 <= byte < 58] or [start]
            place = digits[int(rng.integers(len(digits)))]
            damaged[place:place] = b"9" * int(rng.integers(1, 30))
        case 3:
            del damaged[start:end]
        case 4:
            damaged[start:start] = damaged[start:end]
        case 5:
            noise = rng.integers(0, 256, end - start).astype(np.uint8).tobytes()
            damaged[start:end] = noise
    return bytes(damaged)


def gltf(uri: str | None = None, **accessor: int) -> dict:
    """One triangle; its numbers at an address, or said to be more than they are."""
    data = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0], "<f4").tobytes()
    inside = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    view = {"buffer": 0, "byteLength": len(data)}
    view |= {"byteStride": accessor.pop("byteStride")} if "byteStride" in accessor else {}
    points = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}
    return {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [points | accessor],
        "bufferViews": [view],
        "buffers": [{"byteLength": len(data), "uri": inside if uri is None else uri}],
    }


def lies() -> dict[str, bytes]:
    """Files that promise, nest, grow, point elsewhere or are no numbers; all must be refused."""
    trees = {
        "stride.gltf": gltf(count=3 * 10**9, byteStride=0),
        "count.gltf": gltf(count=10**18),
        "huge-index.gltf": gltf(bufferView=10**30),
        "passwd.gltf": gltf("/etc/passwd"),
        "beside.gltf": gltf("stride.gltf"),
        "up.gltf": gltf("../../../../../../etc/passwd"),
        "encoded.gltf": gltf("%2Fetc%2Fpasswd"),
        "file.gltf": gltf("file:///etc/passwd"),
        "net.gltf": gltf("http://localhost/a.bin"),
        "device.gltf": gltf("/dev/zero"),
    }
    square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\n"
    header = b"ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
    header += b"property float z\nelement face %d\nproperty list uchar int vertex_indices\n"
    header += b"end_header\n"
    vtu = '<VTKFile type="UnstructuredGrid">{}</VTKFile>'
    entities = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 12))
    return {
        **{name: json.dumps(tree).encode() for name, tree in trees.items()},
        "nested.gltf": b'{"asset":' * 100_000,
        "nested-list.gltf": b"[" * 1_000_000,
        "json.glb": b"glTF\2\0\0\0" + (20).to_bytes(4, "little") + b"\xff\xff\xff\x7fJSON",
        "count.stl": bytes(80) + b"\xff\xff\xff\xff" + bytes(500),
        "nan.stl": bytes(80) + b"\1\0\0\0" + b"\xff" * 50,
        "count.ply": header % (10**12, 10**12),
        "negative.ply": header % (-1, -1),
        "endless.ply": header % (10**40, 1),
        "binary.ply": (header % (10**9, 10**9)).replace(b"ascii", b"binary_little_endian"),
        "count.off": b"OFF\n99999999999 99999999999 0\n0 0 0\n",
        "size.off": b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n999999999 0 1 2\n",
        "index.obj": square + b"f 99999999999999999999999 1 2\n",
        "negative.obj": square + b"f -1 -2 -99\n",
        "nan.obj": b"v nan nan nan\n" * 3 + b"f 1 2 3\n",
        "infinite.obj": b"v 1e999 0 0\n" * 3 + b"f 1 2 3\n",
        "gigantic.obj": b"v 1e300 0 0\nv 0 1e300 0\nv 0 0 -1e300\nf 1 2 3\n",
        "tiny.obj": b"v 1e-320 0 0\nv 0 1e-320 0\nv 0 0 0\nf 1 2 3\n",
        "point.obj": b"v 1 1 1\n" * 3 + b"f 1 2 3\n",
        "digits.obj": b"v " + b"9" * 100_000 + b" 0 0\n" + square + b"f 1 2 3\n",
        "cloud.obj": square,
        "library.obj": b"mtllib /etc/passwd\n",
        "empty.obj": b"",
        "zeros.obj": bytes(10_000),
        "archive.obj": _zip_bomb(),
        "archive.ply": _zip_bomb(),
        "bomb.vtp": _vtp_bomb(),
        "size.vtk": b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\n"
        b"POINTS 999999999999 double\n",
        "entities.vtu": f"<!DOCTYPE a [<!ENTITY a0 'a'>{entities}]>{vtu.format('&a11;')}".encode(),
        "external.vtu": b'<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]>'
        + vtu.format("&b;").encode(),
        "count.msh": b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 99999999999 1 9\n"
        b"2 1 0 99999999999\n$EndNodes\n",
        "count.mesh": b"MeshVersionFormatted 2\nDimension 3\nVertices\n999999999999\n0 0 0 1\n",
        "include.inp": b"*HEADING\n*INCLUDE, INPUT=/etc/passwd\n",
        "include.bdf": b"BEGIN BULK\nINCLUDE '/etc/passwd'\nENDDATA\n",
        "device.dat": b"INCLUDE '/dev/zero'\n",
        "unknown.xyz": square,
    }


def _zip_bomb() -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("vertices.npy", bytes(2**24))
    return content.getvalue()


def _vtp_bomb() -> bytes:
    """Blocks of zeros that become 16 GiB."""
    block, count = zlib.compress(bytes(2**24)), 1024
    table = np.array([count, 2**24, 0, *[len(block)] * count], "<u4").tobytes()
    text = base64.b64encode(table + block * count).decode()
    array = f'<DataArray type="Float32" NumberOfComponents="3" format="binary">{text}</DataArray>'
    return (
        '<VTKFile type="PolyData" byte_order="LittleEndian" compressor="vtkZLibDataCompressor">'
        f'<PolyData><Piece NumberOfPoints="9" NumberOfPolys="0"><Points>{array}</Points></Piece>'
        "</PolyData></VTKFile>"
    ).encode()
