"""The structures and constants of plait.h. tests/python/interface_test.py compares both."""

import ctypes
from ctypes import (CFUNCTYPE, POINTER, Structure, c_char, c_char_p, c_double, c_int, c_int32,
                    c_int64, c_size_t, c_uint8, c_uint32, c_uint64, c_void_p)

AUTOMATIC_THREADS = -1
FINEST_LEVEL = -1
OUTERMOST_LEVEL = -1
ALL_LEVELS = -1
DIGEST_BYTES = 33
DEFAULT_BUDGET_BYTES = 256 << 20

ACCESS_UPDATE, ACCESS_OVERWRITE, ACCESS_READ = 0, 1, 2
FLOAT32, FLOAT64 = 1, 2
AUTOMATIC_POSITIONS = -1
# The type of the components of a record, as numpy names it.
TYPES = {1: "<f4", 2: "<f8", 3: "|i1", 4: "<i2", 5: "<i4", 6: "<i8", 7: "|u1", 8: "<u2", 9: "<u4",
         10: "<u8"}

plait_progress = CFUNCTYPE(c_int, c_char_p, c_uint64, c_uint64, c_void_p)
plait_warning = CFUNCTYPE(None, c_char_p, c_void_p)


class Sized(Structure):
    """A structure whose first member is its size."""

    def __init__(self, **members):
        super().__init__(**members)
        self.struct_size = ctypes.sizeof(self)


class plait_store_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("backend", c_char_p), ("pipeline", c_char_p),
        ("layout", c_char_p), ("base_scheme", c_char_p), ("block_bytes", c_uint64),
        ("budget_bytes", c_uint64), ("expected_bytes", c_uint64), ("warn", plait_warning),
        ("user", c_void_p), ("base_level", c_int32), ("io_threads", c_int32),
        ("position_type", c_int32), ("durability", c_int32), ("event", c_void_p),
        ("event_user", c_void_p), ("slow_read_ns", c_uint64), ("parallel_for", c_void_p),
        ("parallel_user", c_void_p)]


class plait_open_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("budget_bytes", c_uint64), ("writable", c_int32),
        ("io_threads", c_int32), ("durability", c_int32), ("reserved", c_int32),
        ("event", c_void_p), ("event_user", c_void_p), ("slow_read_ns", c_uint64),
        ("parallel_for", c_void_p), ("parallel_user", c_void_p)]


class plait_served_file(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("bytes", c_uint64), ("content_type", c_char_p), ("tag", c_char_p)]


class plait_store_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("path", c_char_p), ("backend", c_char_p),
        ("pipeline", c_char_p), ("layout", c_char_p), ("scheme", c_char_p), ("program", c_char_p),
        ("sequence", c_uint64), ("stored_bytes", c_uint64), ("block_bytes", c_uint64),
        ("budget_bytes", c_uint64), ("vertex_count", c_uint64), ("edge_count", c_uint64),
        ("face_count", c_uint64), ("border_edge_count", c_uint64), ("uuid", c_uint8 * 16),
        ("attribute_count", c_uint32), ("base_level", c_int32), ("finest_level", c_int32),
        ("writable", c_int32), ("limit", c_int32), ("precision", c_int32),
        ("notices", c_char_p)]


class plait_attribute_info(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("name", c_char_p), ("record_bytes", c_uint64),
        ("type", c_int32), ("components", c_uint32), ("finest_level", c_int32),
        ("index", c_uint32)]


class plait_input_maps(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("input_vertices", POINTER(c_uint32)),
        ("input_faces", POINTER(c_uint32)), ("turned", POINTER(c_uint8)),
        ("vertices", POINTER(c_uint32)), ("faces", POINTER(c_uint32)), ("vertex_count", c_uint64),
        ("face_count", c_uint64), ("input_vertex_count", c_uint64), ("input_face_count", c_uint64)]


class plait_point(Structure):
    _fields_ = [("face", c_uint32), ("i", c_int32), ("j", c_int32), ("size", c_int32)]


class plait_paging_statistics(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("blocks_read", c_uint64), ("bytes_read", c_uint64),
        ("blocks_written", c_uint64), ("bytes_written", c_uint64), ("blocks_prefetched", c_uint64),
        ("blocks_evicted", c_uint64), ("read_waits", c_uint64), ("read_wait_ns", c_uint64),
        ("write_waits", c_uint64), ("write_wait_ns", c_uint64), ("peak_frame_bytes", c_uint64)]


class plait_subdivide_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("scheme", c_char_p), ("executor", c_char_p),
        ("progress", plait_progress), ("warn", plait_warning), ("user", c_void_p), ("levels", c_int32),
        ("threads", c_int32), ("normals", c_int32), ("limit", c_int32), ("commit_levels", c_int32),
        ("reserved", c_int32)]


class plait_damaged_block(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("attribute", c_char_p), ("reason", c_char_p),
        ("block", c_uint64), ("file_offset", c_uint64), ("first_edge", c_uint32),
        ("edge_after", c_uint32), ("level", c_int32), ("reserved", c_int32)]


class plait_verify_report(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("blocks", c_uint64), ("bytes", c_uint64),
        ("never_written", c_uint64), ("damaged_count", c_uint64)]


class plait_reader_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("attributes", POINTER(c_char_p)),
        ("attribute_count", c_uint64), ("share_bytes", c_uint64), ("eviction", c_int32),
        ("reserved", c_int32)]


class plait_patch_writer_options(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("attributes", POINTER(c_char_p)),
        ("attribute_count", c_uint64), ("share_bytes", c_uint64), ("first_level", c_int32),
        ("last_level", c_int32), ("compare", c_int32), ("reserved", c_int32)]


class plait_visit_attribute(Structure):
    _fields_ = [("name", c_char_p), ("access", c_int32), ("rings", c_int32)]


class plait_batch_records(Structure):
    _fields_ = [("records", c_void_p), ("neighbours", c_void_p)]


class plait_vertex_batch(Sized):
    _fields_ = [
        ("struct_size", c_size_t), ("count", c_uint64), ("levels", POINTER(c_int32)),
        ("places", POINTER(c_uint64)), ("attributes", POINTER(plait_batch_records)),
        ("attribute_count", c_uint64), ("valence", c_int32), ("border", c_int32),
        ("base", c_int32), ("reserved", c_int32)]


plait_damage = CFUNCTYPE(None, POINTER(plait_damaged_block), c_void_p)
plait_visit_batch = CFUNCTYPE(c_int, POINTER(plait_vertex_batch), c_void_p)
