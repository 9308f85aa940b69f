// export/gltf_document.h: the text of a glTF 2.0 file: where its numbers are, and what they mean.
//
// Patches have the same triangles, so they share them. A group of consecutive patches is one
// primitive, with as many patches as 16-bit indices can number; all groups share one list of
// indices, and the last one uses the begin of it. A patch of more vertices is a group of its own,
// with indices of 32 bits. Vertices on the border of two patches are in both.
// Of a store whose faces have depths of their own, patches differ: all are one primitive, with
// vertices and triangles as PatchSelection numbers them.
// Source: Khronos, "glTF 2.0 specification", 2021, sections 3.6 and 3.7; KHR_mesh_quantization.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "export/format_writers.h"
#include "export/gltf_records.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class GltfDocument {
 public:
  /// Without `normals` the file has none. Errors: kInvalidArgument if the numbers would take more
  /// than 2 GiB.
  GltfDocument(const ExportTask& task, const GltfPlacement& placement, bool normals);

  std::span<const GltfColumn> columns() const { return columns_; }
  /// Whether patches have the same triangles. If not, there is one group, and the next three
  /// functions do not apply.
  bool has_equal_patches() const { return !task_->store.has_depths(); }
  std::uint64_t patch_vertices() const { return patch_vertices_; }
  std::uint64_t patches_of_group() const { return patches_of_group_; }
  std::span<const FaceId> group(std::uint64_t number) const;
  std::uint64_t vertices() const {
    return has_equal_patches() ? patch_vertices_ * task_->patches.faces().size()
                               : task_->patches.vertex_count();
  }
  std::uint64_t group_count() const { return group_count_; }
  /// Bytes of an index.
  std::size_t index_bytes() const { return index_bytes_; }
  std::uint64_t total_bytes() const { return total_bytes_; }

  /// `uri`: the file of the numbers; empty: they follow the text in the same file.
  std::string text(std::span<const GltfBounds> bounds, std::string_view uri) const;
  /// text() is not longer, whatever the bounds are.
  std::size_t most_text_bytes(std::string_view uri) const;

 private:
  void add_column(AttributeId attribute, bool normals);
  void describe_color(GltfColumn& column, ComponentType type) const;
  std::uint64_t group_vertices(std::uint64_t number) const {
    return has_equal_patches() ? group(number).size() * patch_vertices_ : vertices();
  }
  std::uint64_t group_indices(std::uint64_t number) const {
    return has_equal_patches() ? 3 * group(number).size() << (2 * task_->patches.refinements())
                               : 3 * task_->patches.triangle_count();
  }
  std::uint64_t index_lists() const {
    return group(group_count_ - 1).size() < patches_of_group_ ? 2 : 1;
  }
  std::string accessors(std::span<const GltfBounds> bounds) const;
  std::string primitives() const;
  std::string views() const;

  const ExportTask* task_;
  const GltfPlacement* placement_;
  std::uint64_t patch_vertices_, patches_of_group_ = 1, group_count_;
  std::size_t index_bytes_ = 4;
  std::vector<GltfColumn> columns_;
  std::uint64_t total_bytes_ = 0;
};

PLAIT_END_NAMESPACE
