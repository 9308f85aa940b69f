// A base mesh in files that is larger than the memory of whoever plans parts of it. All its arrays
// are read from front to back, a run at a time, and what needs another order is sorted in files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "format/base_index_pages.h"
#include "io/unpublished.h"
#include "layout/external_sort.h"
#include "mesh/narrowing.h"
#include "parts/cuts.h"
#include "plait/base_mesh.h"
#include "plait/progress.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class BaseInRanges {
 public:
  /// The directory of the base mesh, as open_base_pages() takes it. Temporary files lie beside
  /// `final_path`, which need not exist. `memory_bytes` are for the sorts; on top come the border,
  /// and what one function has of an array. Errors: those of open_base_pages().
  BaseInRanges(const std::filesystem::path& base, const std::filesystem::path& final_path,
               std::uint64_t memory_bytes);

  /// The memory that the whole mesh takes, and what a plan keeps of it.
  static std::uint64_t whole_bytes(const std::filesystem::path& base);

  /// About how much disk the files of the sorts need at a time: of narrowing(), and of edges().
  static std::uint64_t disk_of_narrowing(const BaseCounts& counts, std::uint64_t memory_bytes);
  static std::uint64_t disk_of_edges(const BaseCounts& counts, std::uint64_t memory_bytes);
  /// Of the mesh in the directory. Errors: those of open_base_pages().
  static BaseCounts counts(const std::filesystem::path& base);

  /// The mesh. Whoever asks it for a whole array, or its topology(), has it in memory.
  const BaseMesh& mesh() const { return mesh_; }
  /// As seam_vertices_of(). Takes memory for the border alone.
  std::uint64_t seam_vertices() const;
  /// As narrowing_of().
  Narrowing narrowing(int levels);
  /// As EdgesInMemory. The object outlives the result.
  std::unique_ptr<EdgesInOrder> edges();

 private:
  template <class Take>
  void each_run(MeshArray array, std::uint64_t count, const Take& take) const;
  template <class Record>
  std::unique_ptr<ExternalSort<Record>> sort() {
    return std::make_unique<ExternalSort<Record>>(scratch_.directory(), sort_memory_);
  }
  void add_merged(Narrowing& result);

  class Edges;

  std::shared_ptr<const BaseIndexPages> pages_;
  BaseMesh mesh_;
  UnpublishedDirectory scratch_;
  SortMemory sort_memory_;  ///< two sorts are under way at most
};

PLAIT_END_NAMESPACE
