"""The functions of plait.h, declared once. The interpreter's lock is free while one of them runs."""

import os
from ctypes import POINTER, c_char_p, c_double, c_int32, c_uint32, c_uint64, c_void_p

from . import _structures as types
from . import errors
from ._library import LIBRARY

_out = POINTER(c_void_p)
_count = POINTER(c_uint64)

# Functions that return a status: the types of their arguments. Pointers to arrays are addresses.
_STATUS = {
    "plait_plugin_load": [c_char_p],
    "plait_store_create": [c_char_p, c_void_p, c_uint64, c_void_p, c_uint64,
                           POINTER(types.plait_store_options), _out],
    "plait_store_open": [c_char_p, POINTER(types.plait_open_options), _out],
    "plait_store_commit": [c_void_p],
    "plait_store_roll_back": [c_void_p],
    "plait_store_get_info": [c_void_p, POINTER(types.plait_store_info)],
    "plait_store_get_attribute": [c_void_p, c_uint32, POINTER(types.plait_attribute_info)],
    "plait_store_get_depths": [c_void_p, c_void_p, c_uint64],
    "plait_store_get_triangles": [c_void_p, c_int32, c_void_p, c_uint64, c_void_p],
    "plait_store_get_counts": [c_void_p, c_int32, _count, _count, _count],
    "plait_store_get_faces": [c_void_p, _out, _count],
    "plait_store_get_base_positions": [c_void_p, _out, _count],
    "plait_store_find_attribute": [c_void_p, c_char_p, POINTER(types.plait_attribute_info)],
    "plait_store_get_input_maps": [c_void_p, POINTER(types.plait_input_maps)],
    "plait_store_get_points": [c_void_p, c_int32, c_uint64, c_uint64, c_void_p],
    "plait_store_get_text": [c_void_p, c_char_p, POINTER(c_char_p)],
    "plait_store_get_text_name": [c_void_p, c_uint32, POINTER(c_char_p)],
    "plait_store_set_text": [c_void_p, c_char_p, c_char_p],
    "plait_store_get_face_attribute": [c_void_p, c_uint32, POINTER(types.plait_attribute_info)],
    "plait_store_get_face_records": [c_void_p, c_char_p, _out, _count],
    "plait_store_edit_face_records": [c_void_p, c_char_p, _out, _count],
    "plait_store_add_face_attribute": [c_void_p, c_char_p, c_int32],
    "plait_store_remove_face_attribute": [c_void_p, c_char_p],
    "plait_store_edit_base_records": [c_void_p, c_char_p, _out, _count],
    "plait_store_set_pipeline": [c_void_p, c_char_p, c_char_p],
    "plait_store_recode_attribute": [c_void_p, c_char_p, c_char_p],
    "plait_store_get_statistics": [c_void_p, POINTER(types.plait_paging_statistics)],
    "plait_store_add_attribute": [c_void_p, c_char_p, c_int32, c_uint32, c_int32],
    "plait_store_replace_attribute": [c_void_p, c_char_p, c_char_p],
    "plait_store_remove_attribute": [c_void_p, c_char_p],
    "plait_store_subdivide": [c_void_p, POINTER(types.plait_subdivide_options)],
    "plait_store_digest": [c_void_p, c_int32, c_int32, types.plait_progress, c_void_p, c_char_p],
    "plait_store_write_bounds": [c_void_p, c_char_p, types.plait_progress, c_void_p],
    "plait_store_verify": [c_void_p, types.plait_progress, types.plait_damage, c_void_p,
                           POINTER(types.plait_verify_report)],
    "plait_store_visit": [c_void_p, POINTER(types.plait_visit_attribute), c_uint64, c_int32,
                          c_int32, types.plait_visit_batch, types.plait_progress, c_void_p],
    "plait_reader_open": [c_void_p, POINTER(types.plait_reader_options), _out],
    "plait_reader_faces_in_box": [c_void_p, c_char_p, POINTER(c_double), POINTER(c_double),
                                  c_void_p, c_uint64, _count],
    "plait_reader_faces_along_ray": [c_void_p, c_char_p, POINTER(c_double), POINTER(c_double),
                                     c_void_p, c_void_p, c_uint64, _count],
    "plait_reader_patch_indices": [c_void_p, c_int32, c_void_p, c_uint64, _count],
    "plait_reader_vertex_count": [c_void_p, c_int32, _count],
    "plait_reader_read_vertices": [c_void_p, c_char_p, c_int32, c_uint64, c_uint64, c_void_p,
                                   c_uint64],
    "plait_reader_copy_patches": [c_void_p, c_char_p, c_void_p, c_uint64, c_int32, c_void_p,
                                  c_uint64],
    "plait_reader_prefetch": [c_void_p, c_void_p, c_uint64, c_int32, _count],
    "plait_reader_end_prefetch": [c_void_p],
    "plait_reader_weld_patches": [c_void_p, c_void_p, c_uint64, c_int32, c_void_p, c_uint64,
                                  _count],
    "plait_reader_get_blocks": [c_void_p, c_char_p, c_int32, c_void_p, c_uint64, _count],
    "plait_reader_pin_vertices": [c_void_p, c_char_p, c_int32, c_uint64, c_uint64, _out, _out,
                                  _count],
    "plait_patch_writer_open": [c_void_p, POINTER(types.plait_patch_writer_options), _out],
    "plait_patch_writer_write_patch": [c_void_p, c_char_p, c_uint32, c_int32, c_void_p, c_uint64],
    "plait_patch_writer_write_level": [c_void_p, c_char_p, c_uint32, c_int32, c_void_p, c_uint64],
    "plait_patch_writer_finish": [c_void_p],
    "plait_served_open": [c_void_p, types.plait_progress, c_void_p, _out],
    "plait_served_find": [c_void_p, c_char_p, POINTER(types.plait_served_file)],
    "plait_served_read": [c_void_p, c_char_p, c_uint64, c_void_p, c_uint64],
    "plait_job_options": [c_char_p, _out],
    "plait_job_run": [c_char_p, POINTER(c_char_p), c_uint64, types.plait_progress,
                      types.plait_warning, c_void_p, _out],
}
# Functions that return nothing.
_NOTHING = {
    "plait_store_release": [c_void_p],
    "plait_reader_close": [c_void_p],
    "plait_patch_writer_close": [c_void_p],
    "plait_pin_release": [c_void_p],
    "plait_served_close": [c_void_p],
    "plait_text_release": [c_void_p],
}
_TEXT = {"plait_version_string": [], "plait_build_info": [], "plait_text_string": [c_void_p]}


def _checked(status, function, arguments):
    if status:
        raise errors.of_status(status)
    return status


for _name, _arguments in _STATUS.items():
    _function = getattr(LIBRARY, _name)
    _function.argtypes = _arguments
    _function.restype = c_int32
    _function.errcheck = _checked
for _name, _arguments in _NOTHING.items():
    _function = getattr(LIBRARY, _name)
    _function.argtypes = _arguments
    _function.restype = None
for _name, _arguments in _TEXT.items():
    getattr(LIBRARY, _name).argtypes = _arguments
    getattr(LIBRARY, _name).restype = c_char_p


def _whole(value):
    """The bytes, if they have no end inside, where the library would stop to read them."""
    if b"\0" in value:
        raise ValueError("embedded null byte")
    return value


def text(value):
    """A text for the library; None stays None."""
    return None if value is None else _whole(str(value).encode())


def path(value):
    """A path for the library."""
    return _whole(os.fsencode(value))


def texts(values):
    """An array of texts for the library."""
    return (c_char_p * max(1, len(values)))(*values)


def taken_text(address):
    """A text that a call has made, which ends here."""
    try:
        return LIBRARY.plait_text_string(address).decode(errors="replace")
    finally:
        LIBRARY.plait_text_release(address)
