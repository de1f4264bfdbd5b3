"""Peers with a Python interface: VTK, trimesh, Open3D, libigl. Loop's scheme only.

    peers.py LIBRARY MESH.obj SCHEME LEVELS REPEATS

Prints one line of JSON as the programs in C++ do, see peer.hpp: numpy arrays to the library's own
structure, refined, and numpy arrays again.
"""

import importlib.util
import json
import sys
import time
from pathlib import Path

import numpy as np


class Vtk:
    module = "vtk"

    def __init__(self):
        # Only what is used: the whole of VTK takes seconds to load.
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkPoints, vtkVersion
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
        from vtkmodules.vtkFiltersModeling import vtkLoopSubdivisionFilter

        self.to_vtk, self.to_ids, self.to_numpy = numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
        self.points, self.cells, self.data = vtkPoints, vtkCellArray, vtkPolyData
        self.filter = vtkLoopSubdivisionFilter
        self.name = "VTK " + vtkVersion.GetVTKVersion()

    def build(self, points, faces):
        data, at, cells = self.data(), self.points(), self.cells()
        at.SetData(self.to_vtk(points))
        starts = np.arange(0, 3 * len(faces) + 1, 3, dtype=np.int64)
        # The arrays are shared, so they have to live as long as the filter does.
        self.shared = (points, starts, faces.astype(np.int64).ravel())
        cells.SetData(self.to_ids(starts), self.to_ids(self.shared[2]))
        data.SetPoints(at)
        data.SetPolys(cells)
        return data

    def refine(self, data, levels):
        subdivide = self.filter()
        subdivide.SetInputData(data)
        subdivide.SetNumberOfSubdivisions(levels)
        subdivide.Update()
        return subdivide.GetOutput()

    def extract(self, data):
        corners = self.to_numpy(data.GetPolys().GetConnectivityArray())
        return self.to_numpy(data.GetPoints().GetData()), corners.reshape(-1, 3)


class Trimesh:
    module = "trimesh"

    def __init__(self):
        import trimesh
        from trimesh.remesh import subdivide_loop

        self.subdivide = subdivide_loop
        self.name = "trimesh " + trimesh.__version__

    def build(self, points, faces):
        return points, faces

    def refine(self, mesh, levels):
        return self.subdivide(*mesh, iterations=levels)

    def extract(self, mesh):
        return mesh


class Open3d:
    module = "open3d"

    def __init__(self):
        import open3d

        self.geometry, self.utility = open3d.geometry, open3d.utility
        self.name = "Open3D " + open3d.__version__

    def build(self, points, faces):
        vectors = self.utility.Vector3dVector(points), self.utility.Vector3iVector(faces)
        return self.geometry.TriangleMesh(*vectors)

    def refine(self, mesh, levels):
        return mesh.subdivide_loop(levels)

    def extract(self, mesh):
        return np.asarray(mesh.vertices), np.asarray(mesh.triangles)


class Igl:
    module = "igl"

    def __init__(self):
        from importlib.metadata import version

        import igl

        self.loop = igl.loop
        self.name = "libigl " + version("libigl")

    def build(self, points, faces):
        return points, faces

    def refine(self, mesh, levels):
        return self.loop(*mesh, number_of_subdivs=levels)

    def extract(self, mesh):
        return mesh


LIBRARIES = {"vtk": Vtk, "trimesh": Trimesh, "open3d": Open3d, "igl": Igl}


def read_obj(path):
    """Vertices and triangles; all else in the file is left aside."""
    points, faces = [], []
    for line in Path(path).read_text().splitlines():
        words = line.split()
        if words and words[0] == "v":
            points.append([float(x) for x in words[1:4]])
        elif words and words[0] == "f":
            faces.append([int(x) - 1 for x in words[1:]])
    return np.array(points), np.array(faces, dtype=np.int32)


def status_bytes(name):
    """Bytes that /proc/self/status names."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(name):
            return 1024 * int(line.split()[1])
    return 0


def main():
    if sys.argv[1:2] == ["--has"]:
        return 0 if importlib.util.find_spec(LIBRARIES[sys.argv[2]].module) else 1
    library, path, scheme, levels, repeats = sys.argv[1:6]
    if scheme != "loop":
        sys.exit("Loop's scheme only")
    library = LIBRARIES[library]()
    points, faces = read_obj(path)
    samples, cpu = [], []
    before = status_bytes("VmRSS:")
    Path("/proc/self/clear_refs").write_text("5")
    for i in range(int(repeats)):
        ticks, cpu_start = [time.perf_counter()], time.process_time()
        mesh = library.build(points, faces)
        ticks.append(time.perf_counter())
        mesh = library.refine(mesh, int(levels))
        ticks.append(time.perf_counter())
        fine, corners = library.extract(mesh)
        ticks.append(time.perf_counter())
        cpu.append(time.process_time() - cpu_start)
        samples.append(np.diff(ticks).tolist())
        if i == 0:
            peak = status_bytes("VmHWM:") - before
            fine = np.asarray(fine, dtype=np.float64)
            result = {
                "library": library.name,
                "vertices": len(fine),
                "faces": len(corners),
                "mean": fine.mean(axis=0).tolist(),
                "min": fine.min(axis=0).tolist(),
                "max": fine.max(axis=0).tolist(),
                "square": [float((fine**2).sum(axis=1).mean())],
            }
        del mesh, fine, corners
    print(json.dumps(result | {"cpu": cpu, "samples": samples, "bytes": peak}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
