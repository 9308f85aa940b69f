// tests/c/functions.h: for each function of plait.h, what it is in C++; and the public functions of
// Store and Reader that the C interface leaves out, each with a reason. functions_test.cpp compares
// both lists with the headers. A new function of these classes belongs in one of the lists.
#pragma once

#include <string_view>
#include <vector>

#include "plait.h"

namespace plait::test {

using AnyFunction = void (*)();

/// `cpp` has all functions of C++ that the function stands for. A name without "::" is a free
/// function; an empty list is for functions that only C needs.
struct CFunction {
  std::string_view name;
  AnyFunction address;
  std::vector<std::string_view> cpp;
};

#define PLAIT_PAIR(name, ...)                                      \
  {                                                                \
#name, reinterpret_cast < AnyFunction>(&name), { __VA_ARGS__ } \
  }
inline const std::vector<CFunction> kCFunctions{
    PLAIT_PAIR(plait_error_message),
    PLAIT_PAIR(plait_error_path),
    PLAIT_PAIR(plait_error_offset),
    PLAIT_PAIR(plait_status_name, "to_string"),
    PLAIT_PAIR(plait_abi_version),
    PLAIT_PAIR(plait_version_string, "program_version"),
    PLAIT_PAIR(plait_build_info, "default_backends", "default_pipelines", "schemes"),
    PLAIT_PAIR(plait_plugin_load, "Plugins::load"),
    PLAIT_PAIR(plait_store_create, "Store::create", "BaseMesh::build", "lay_out", "rebase",
               "add_base_positions"),
    PLAIT_PAIR(plait_store_create_from_file, "Store::create", "read_base_mesh"),
    PLAIT_PAIR(plait_store_open, "Store::open"),
    PLAIT_PAIR(plait_store_has_commit, "Store::has_commit"),
    PLAIT_PAIR(plait_store_commit, "Store::commit"),
    PLAIT_PAIR(plait_store_roll_back, "Store::roll_back"),
    PLAIT_PAIR(plait_store_close, "Store::close"),
    PLAIT_PAIR(plait_store_release, "Store::~Store"),
    PLAIT_PAIR(plait_store_get_info, "Store::path", "Store::options", "Store::info",
               "Store::sequence", "Store::provenance", "Store::base_level", "Store::finest_level"),
    PLAIT_PAIR(plait_store_get_attribute, "Store::attributes"),
    PLAIT_PAIR(plait_store_find_attribute, "Store::attribute", "Store::has_attribute"),
    PLAIT_PAIR(plait_store_get_counts, "counts_at_level"),
    PLAIT_PAIR(plait_store_get_triangles, "for_each_numbered_triangle"),
    PLAIT_PAIR(plait_store_get_depths, "Store::depth", "Store::has_depths", "Reader::depth",
               "Reader::depth_across"),
    PLAIT_PAIR(plait_store_get_faces, "Store::base"),
    PLAIT_PAIR(plait_store_get_base_positions, "Store::base"),
    PLAIT_PAIR(plait_store_get_input_maps, "BaseMesh::input_maps"),
    PLAIT_PAIR(plait_store_get_points, "VertexRun::point"),
    PLAIT_PAIR(plait_store_set_text, "Store::notes", "StoreNotes::set_text"),
    PLAIT_PAIR(plait_store_get_text, "StoreNotes::texts"),
    PLAIT_PAIR(plait_store_get_text_name, "StoreNotes::texts"),
    PLAIT_PAIR(plait_store_add_face_attribute, "StoreNotes::add_face_attribute"),
    PLAIT_PAIR(plait_store_remove_face_attribute, "StoreNotes::remove_face_attribute"),
    PLAIT_PAIR(plait_store_get_face_attribute, "StoreNotes::face_attributes"),
    PLAIT_PAIR(plait_store_get_face_records, "StoreNotes::face_records", "StoreNotes::face_bytes"),
    PLAIT_PAIR(plait_store_edit_face_records, "StoreNotes::face_records", "StoreNotes::face_bytes"),
    PLAIT_PAIR(plait_store_get_statistics, "Store::info"),
    PLAIT_PAIR(plait_store_add_attribute, "Store::add_attribute", "Store::add_level"),
    PLAIT_PAIR(plait_store_add_level, "Store::add_level"),
    PLAIT_PAIR(plait_store_set_pipeline, "Store::set_pipeline"),
    PLAIT_PAIR(plait_store_replace_attribute, "Store::replace_attribute"),
    PLAIT_PAIR(plait_store_remove_attribute, "Store::remove_attribute"),
    PLAIT_PAIR(plait_store_recode_attribute, "recode_attribute"),
    PLAIT_PAIR(plait_store_get_base_records, "Store::base_records", "Store::base_bytes"),
    PLAIT_PAIR(plait_store_edit_base_records, "Store::base_records", "Store::base_bytes"),
    PLAIT_PAIR(plait_store_subdivide, "subdivide"),
    PLAIT_PAIR(plait_store_digest, "digest"),
    PLAIT_PAIR(plait_store_write_bounds, "write_bounds"),
    PLAIT_PAIR(plait_store_verify, "verify"),
    PLAIT_PAIR(plait_reader_open, "Reader::Reader"),
    PLAIT_PAIR(plait_reader_close, "Reader::~Reader"),
    PLAIT_PAIR(plait_reader_read_patch, "Reader::read_patch"),
    PLAIT_PAIR(plait_reader_visit_patches, "Reader::for_each_patch"),
    PLAIT_PAIR(plait_reader_prefetch, "Reader::prefetch"),
    PLAIT_PAIR(plait_reader_end_prefetch, "Reader::end_prefetch"),
    PLAIT_PAIR(plait_reader_faces_in_box, "Reader::faces_in_box"),
    PLAIT_PAIR(plait_reader_faces_along_ray, "Reader::faces_along_ray"),
    PLAIT_PAIR(plait_reader_patch_indices, "Reader::patch_indices"),
    PLAIT_PAIR(plait_reader_vertex_count, "Reader::vertex_count"),
    PLAIT_PAIR(plait_reader_read_vertices, "Reader::for_each_block",
               "Reader::for_each_block_of_bytes"),
    PLAIT_PAIR(plait_reader_visit_vertices, "Reader::for_each_block",
               "Reader::for_each_block_of_bytes"),
    PLAIT_PAIR(plait_reader_view_count, "Reader::view_count"),
    PLAIT_PAIR(plait_reader_get_statistics, "Reader::statistics"),
    PLAIT_PAIR(plait_patch_writer_open, "PatchWriter::PatchWriter"),
    PLAIT_PAIR(plait_patch_writer_write_patch, "PatchWriter::write_patch",
               "PatchWriter::write_patch_of_bytes"),
    PLAIT_PAIR(plait_patch_writer_write_level, "PatchWriter::write_level",
               "PatchWriter::write_level_of_bytes"),
    PLAIT_PAIR(plait_patch_writer_finish, "PatchWriter::finish"),
    PLAIT_PAIR(plait_patch_writer_get_statistics, "PatchWriter::statistics"),
    PLAIT_PAIR(plait_patch_writer_close, "PatchWriter::~PatchWriter"),
    PLAIT_PAIR(plait_view_get_info, "PatchView::face", "PatchView::level", "PatchView::size"),
    PLAIT_PAIR(plait_view_at, "PatchView::attribute", "PatchView::records"),
    PLAIT_PAIR(plait_view_copy, "PatchView::attribute", "PatchView::records"),
    PLAIT_PAIR(plait_view_release, "PatchView::~PatchView"),
    PLAIT_PAIR(plait_reader_copy_patches, "Reader::copy_patches"),
    PLAIT_PAIR(plait_reader_weld_patches, "Reader::weld_patches"),
    PLAIT_PAIR(plait_reader_get_blocks, "Reader::block_starts"),
    PLAIT_PAIR(plait_reader_pin_vertices, "Reader::pin_vertices", "PinnedVertices::bytes"),
    PLAIT_PAIR(plait_pin_release, "PinnedVertices::~PinnedVertices"),
    PLAIT_PAIR(plait_store_visit, "visit_vertices"),
    PLAIT_PAIR(plait_served_open, "ServedStore::ServedStore"),
    PLAIT_PAIR(plait_served_find, "ServedStore::find"),
    PLAIT_PAIR(plait_served_read, "ServedStore::read"),
    PLAIT_PAIR(plait_served_close, "ServedStore::~ServedStore"),
    PLAIT_PAIR(plait_parts_make, "make_part"),
    PLAIT_PAIR(plait_job_options, "job_description_json", "known_jobs", "find_job"),
    PLAIT_PAIR(plait_job_run, "run_job"),
    PLAIT_PAIR(plait_text_string),
    PLAIT_PAIR(plait_text_release),
};
#undef PLAIT_PAIR

struct LeftOut {
  std::string_view cpp, reason;
};
inline const std::vector<LeftOut> kLeftOut{
    {"Store::Store", "a handle in C is a pointer, which is copied and not moved"},
    {"Store::operator=", "as Store::Store"},
    {"StoreNotes::StoreNotes", "as Store::Store"},
    {"StoreNotes::operator=", "as Store::Store"},
    {"Store::finish_encoding", "plait_store_commit() does it"},
    {"Reader::operator=", "as Store::Store"},
    {"PatchWriter::operator=", "as Store::Store"},
    {"PatchView::PatchView", "as Store::Store"},
    {"PatchView::operator=", "as Store::Store"},
};

}  // namespace plait::test
