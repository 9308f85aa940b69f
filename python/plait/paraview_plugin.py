"""Stores in ParaView: load this file under Tools, Manage Plugins, Load New; or in a script,
LoadPlugin(plait.__path__[0] + "/paraview_plugin.py", ns=globals()).

File, Open then opens the directory of a store. The properties are those of plait.vtk.Reader. The
interpreter of ParaView must find the package plait: set PYTHONPATH if it is not installed there.
"""

from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy

from plait import vtk

_EVERYWHERE = [-1e300, 1e300] * 3


@smproxy.reader(name="PlaitReader", label="Plait Reader", extensions="plait",
                file_description="plait store", is_directory=True)
class PlaitReader(vtk.Reader):
    """A level of a store, or the part of it in a box, with the attributes that are chosen."""

    @smproperty.stringvector(name="FileName")
    @smdomain.filelist()
    @smhint.filechooser(extensions="plait", file_description="plait store")
    def SetFileName(self, file):
        """The directory of the store."""
        super().SetFileName(file)

    @smproperty.intvector(name="Level", default_values=-1)
    @smdomain.intrange(min=-1, max=20)
    def SetLevel(self, level):
        """The level to read; -1 for the finest one."""
        super().SetLevel(level)

    @smproperty.doublevector(name="Box", default_values=_EVERYWHERE)
    def SetBox(self, x0, x1, y0, y1, z0, z1):
        """Only patches that reach into this box."""
        everywhere = [x0, x1, y0, y1, z0, z1] == _EVERYWHERE
        super().SetBox(None if everywhere else ((x0, y0, z0), (x1, y1, z1)))

    @smproperty.intvector(name="MemoryMiB", default_values=4096)
    def SetMemoryMiB(self, mebibytes):
        """A mesh that needs more memory is refused."""
        super().SetMemory(mebibytes << 20)

    @smproperty.dataarrayselection(name="Attributes")
    def GetAttributes(self):
        """The attributes besides the positions."""
        return super().GetAttributes()
