"""Stores in VTK: a reader that gives a level, or a part of it, as polygons.

    from plait.vtk import Reader
    reader = Reader("molecule.plait", level=4, box=(low, high), attributes=["normal"])
    reader.Update()
    reader.GetOutput()                       # a vtkPolyData

It needs VTK 9 with its Python modules. docs/python.md is the page about it, and
plait/paraview_plugin.py is the same reader as a plug-in of ParaView.
"""

import os

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkDataArraySelection, vtkLogger, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

from . import _memory
from ._reading import corners, three_numbers
from .errors import Error
from .store import open_store
from .visits import names_of


def polydata(mesh):
    """A plait.Mesh as vtkPolyData. VTK points to the vertices and attributes of the mesh, and keeps
    them."""
    points = vtkPoints()
    points.SetData(numpy_to_vtk(mesh.vertices))
    corners = mesh.triangles.ravel()
    # The same bits as signed numbers if they fit, without a copy.
    corners = (corners.astype(np.int64) if len(mesh.vertices) >= 1 << 31
               else corners.view(np.int32))
    after = np.arange(0, corners.size + 1, 3, dtype=corners.dtype)
    cells = vtkCellArray()
    # Copies: VTK takes the memory of these arrays, and does not keep the arrays.
    cells.SetData(numpy_to_vtk(after, deep=True), numpy_to_vtk(corners, deep=True))
    data = vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    for name, records in mesh.attributes.items():
        array = numpy_to_vtk(records)
        array.SetName(name)
        data.GetPointData().AddArray(array)
        if name == "normal" and array.GetNumberOfComponents() == 3:
            data.GetPointData().SetActiveNormals(name)
    return data


def _numbers(box):
    """A box as two tuples of numbers, which can be compared and do not follow the arrays of the caller."""
    if box is None:
        return None
    return tuple(tuple(three_numbers(name, corner))
                 for name, corner in zip(("low", "high"), corners(box)))


class Reader(VTKPythonAlgorithmBase):
    """Reads a store as vtkPolyData. In a parallel program each process gets a part of the patches.

    file: the directory of the store, or a file in it. level: -1 for the finest one.
    box: (low, high); None: the whole surface. attributes: names, besides the positions.
    memory: refuses to make a mesh that needs more, in words; a number or a text such as "4GiB".

    After Modified(), Update() shows the last committed version.
    """

    def __init__(self, file=None, level=-1, box=None, attributes=(), memory="4GiB"):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkPolyData")
        self._file = None if file is None else os.fspath(file)
        self._level = level
        self._box = _numbers(box)
        self._memory = _memory.bytes_of(memory)
        self._store = None
        self._attributes = vtkDataArraySelection()
        for name in names_of(attributes):
            self._attributes.EnableArray(name)
        self._attributes.AddObserver("ModifiedEvent", lambda *_: self.Modified())

    def SetFileName(self, file):
        """The directory of the store, or a file in it."""
        file = None if file is None else os.fspath(file)
        if file != self._file:
            self._file, self._store = file, None
            self.Modified()

    def GetFileName(self):
        """What SetFileName() got."""
        return self._file

    def SetLevel(self, level):
        """The level to read; -1 for the finest one."""
        if level != self._level:
            self._level = level
            self.Modified()

    def SetBox(self, box):
        """(low, high): only patches whose bounds meet the box; None: the whole surface."""
        box = _numbers(box)
        if box != self._box:
            self._box = box
            self.Modified()

    def SetMemory(self, memory):
        """The most memory for the mesh."""
        if _memory.bytes_of(memory) != self._memory:
            self._memory = _memory.bytes_of(memory)
            self.Modified()

    def GetAttributes(self):
        """A vtkDataArraySelection: the attributes that the output has besides the positions."""
        return self._attributes

    def GetOutput(self):
        """The vtkPolyData."""
        return self.GetOutputDataObject(0)

    def _open(self):
        if self._store is None:
            path = self._file
            self._store = open_store(os.path.dirname(path) if os.path.isfile(path) else path)
        return self._store

    def RequestInformation(self, request, inputs, outputs):
        """Called by VTK: which attributes there are, and that the reader can read parts."""
        try:
            store = self._open()
            store.refresh()
        except Error as error:
            self._store = None
            return self._failed(error)
        there = set(store.attributes) - {"position"}
        for name in self._names():
            if name not in there and not self._attributes.ArrayIsEnabled(name):
                self._attributes.RemoveArrayByName(name)
        for name in sorted(there):
            if not self._attributes.ArrayExists(name):
                self._attributes.AddArray(name, False)
        outputs.GetInformationObject(0).Set(vtkAlgorithm.CAN_HANDLE_PIECE_REQUEST(), 1)
        return 1

    def RequestData(self, request, inputs, outputs):
        """Called by VTK: reads."""
        information = outputs.GetInformationObject(0)
        pipeline = vtkStreamingDemandDrivenPipeline
        piece = information.Get(pipeline.UPDATE_PIECE_NUMBER())
        pieces = information.Get(pipeline.UPDATE_NUMBER_OF_PIECES())
        try:
            mesh = self._mesh(max(piece or 0, 0), max(pieces or 1, 1))
        except Error as error:
            return self._failed(error)
        vtkPolyData.GetData(outputs).ShallowCopy(polydata(mesh))
        return 1

    def _mesh(self, piece, pieces):
        store = self._open()
        level = None if self._level < 0 else self._level
        if self._box is None:
            faces = np.arange(len(store.base.triangles), dtype=np.uint32)
        else:
            faces = store.faces_in_box(*self._box)
        first, after = (len(faces) * each // pieces for each in (piece, piece + 1))
        wanted = [name for name in self._names() if self._attributes.ArrayIsEnabled(name)]
        depths = store.depths
        if self._box is None and depths.min() < depths.max():
            # Faces with depths of their own can be had together only: the first piece has them all.
            if piece == 0:
                return store.mesh(level, attributes=wanted, memory=self._memory)
            level, after = int(depths.min()), first
        return store.mesh(level, faces=faces[first:after], attributes=wanted, memory=self._memory)

    def _names(self):
        return [self._attributes.GetArrayName(number)
                for number in range(self._attributes.GetNumberOfArrays())]

    def _failed(self, error):
        vtkLogger.Log(vtkLogger.VERBOSITY_ERROR, __file__, 0, f"plait: {error}")
        return 0


def read(file, **options):
    """The vtkPolyData of a store: the arguments of Reader. Errors are those of plait."""
    reader = Reader(file, **options)
    return polydata(reader._mesh(0, 1))


def read_for_pyvista(file, **options):
    """What pyvista.read() calls for a directory that ends in .plait: the arguments of Reader. Returns
    a mesh of PyVista."""
    import pyvista
    return pyvista.wrap(read(file, **options))
