// Writes the file base.mesh of a mesh that is not in memory: its numbers come one after another,
// and wait in a file, in planes, until all of them can be compressed from front to back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "format/base_mesh_file.h"
#include "format/packed_mesh.h"
#include "format/planes.h"
#include "layout/temporary_file.h"
#include "plait/extend/directory.h"
#include "plait/extend/file.h"
#include "plait/extend/vector3.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

/// Planes (format/planes.h) of numbers that come in their order.
template <class Word>
class PlaneWriters {
 public:
  PlaneWriters(File& file, std::uint64_t offset, std::uint64_t count) {
    for (std::size_t plane = 0; plane < sizeof(Word); ++plane)
      writers_.emplace_back(file, offset + plane * count, std::size_t{1} << 16);
  }
  void put(Word word) {
    for (std::size_t plane = 0; plane < sizeof(Word); ++plane)
      writers_[plane].put(static_cast<std::byte>(word >> (8 * plane)));
  }
  void flush() {
    for (SequentialWriter& writer : writers_) writer.flush();
  }

 private:
  std::vector<SequentialWriter> writers_;
};

/// Numbers of which each is stored as the difference to the one before.
template <class Word>
class DifferenceWriter {
 public:
  DifferenceWriter(File& file, std::uint64_t offset, std::uint64_t count)
      : planes_(file, offset, count) {}
  void put(Word number) {
    planes_.put(zigzag(static_cast<Word>(number - std::exchange(last_, number))));
  }
  void flush() { planes_.flush(); }

 private:
  PlaneWriters<Word> planes_;
  Word last_ = 0;
};

class PackedWriter {
 public:
  PackedWriter(const Directory& in, std::uint64_t vertex_count, std::uint64_t face_count,
               std::uint64_t input_vertex_count, PositionWords words);

  void put_position(const Vector3<double>& position);  ///< places ascending
  void put_corner(std::uint32_t code) { corners_.put(code); }
  void put_number(VertexId vertex) { numbers_.put(vertex); }  ///< places ascending
  void put_input_vertex(VertexId vertex) { input_vertices_.put(vertex); }
  void put_input_face(std::uint32_t entry) { input_faces_.put(entry); }

  std::uint64_t content_bytes() const { return mesh_bytes_ + maps_bytes_; }
  /// Compresses all, creates base.mesh and syncs it. Tells `done` after every step how many bytes
  /// of the content it has taken. REQUIRES: all numbers were put. Errors: kNotSupported as
  /// refuse_bomb(); kIo, kNoSpace, kOutOfMemory; those of `done`.
  StoredSize finish(const std::function<void(std::uint64_t bytes)>& done);

 private:
  const Directory* in_;
  std::uint64_t vertex_count_, face_count_, input_vertex_count_;
  PositionWords words_;
  std::uint64_t mesh_bytes_, maps_bytes_;
  File content_;
  PlaneWriters<std::uint32_t> corners_;
  DifferenceWriter<std::uint32_t> numbers_, input_vertices_, input_faces_;
  std::vector<DifferenceWriter<std::uint32_t>> short_coordinates_;  ///< of words of 4 bytes
  std::vector<DifferenceWriter<std::uint64_t>> long_coordinates_;   ///< of words of 8 bytes
};

PLAIT_END_NAMESPACE
