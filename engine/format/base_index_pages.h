// The arrays of a file base.index, read by pages into memory of this process.
//
// The file is not mapped. A mapped page that Linux dropped and reads again from a failing disk, or
// from a file that was cut short meanwhile, is a signal (SIGBUS), and one that another process
// changes after it was checked is trusted. Here both are errors: each page is read once, into
// addresses that were reserved for the whole file, and checked there. Pages that nobody asks for
// take no memory.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "format/base_index_file.h"
#include "format/base_index_layout.h"
#include "plait/base_mesh.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

class BaseIndexPages final : public MeshPages {
 public:
  /// Reads the head and the border edges. Errors: kCorruption unless the file has the size and the
  /// head that are expected; kIo, kOutOfMemory.
  /// `base_mesh` is the file base.mesh from which it follows, if a store may copy both.
  BaseIndexPages(File file, const ExpectedBase& expected, File base_mesh = {});

  const MeshArrays& arrays() const noexcept override { return arrays_; }
  void need(MeshArray array) const override;
  void need_topology() const override;
  void need_face(FaceId face) const override;
  void need_elements(MeshArray array, std::span<const std::uint32_t> elements) const override;
  void need_range(MeshArray array, std::uint64_t first, std::uint64_t after) const override;
  void check_sides(std::span<const FaceId> faces) const override;
  [[noreturn]] void refuse(MeshArray array, std::uint64_t element,
                           const std::string& what) const override;
  void forget(MeshArray array, std::uint64_t first, std::uint64_t after) const override;
  std::uint64_t memory_bytes() const noexcept override;
  StoredBase stored() const noexcept override;

 private:
  /// Addresses for the arrays; a page of them takes memory when it is written first.
  class Reservation {
   public:
    Reservation() = default;
    explicit Reservation(std::uint64_t bytes);
    ~Reservation();
    Reservation(Reservation&& other) noexcept;
    Reservation& operator=(Reservation&& other) noexcept;
    std::byte* data() const noexcept { return data_; }

   private:
    std::byte* data_ = nullptr;
    std::uint64_t bytes_ = 0;
  };

  [[noreturn]] void refuse(std::uint64_t offset, const std::string& what) const;
  void read_head(const ExpectedBase& expected);
  /// The array in memory, whether it was read or not.
  std::byte* memory_of(MeshArray array) const noexcept;
  template <class Element>
  std::span<const Element> array(MeshArray which) const noexcept;
  /// The page is one of the array, from 0 on.
  void need_page(MeshArray array, std::uint64_t page) const;
  void need_element(MeshArray array, std::uint64_t index) const;
  void check_page(MeshArray array, std::uint64_t first, std::span<const std::byte> bytes) const;
  void check_border() const;
  /// Whether the face's sides and their edges agree.
  void check_sides(FaceId face) const;
  void check_side(FaceSide side) const;

  static constexpr std::size_t kLocks = 32;

  File file_, base_mesh_;
  std::uint64_t base_mesh_checksum_;
  std::string_view cure_;
  BaseCounts counts_;
  BaseIndexLayout layout_;
  std::vector<std::uint64_t> checksums_;  ///< [page of the file]
  Reservation memory_;
  MeshArrays arrays_;
  /// [page of the file] whether it is in memory and checked. Set with the page's lock held.
  std::unique_ptr<std::atomic<bool>[]> ready_;
  mutable std::array<std::mutex, kLocks> locks_;
  mutable std::array<std::atomic<bool>, kMeshArrayCount> whole_{};
  mutable std::atomic<bool> topology_whole_ = false;
  mutable std::atomic<std::uint64_t> read_bytes_ = 0;
};

PLAIT_END_NAMESPACE
