#include "format/view_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/iostreams/device/array.hpp>
#include <boost/iostreams/device/back_inserter.hpp>
#include <boost/iostreams/filter/zlib.hpp>
#include <boost/iostreams/filtering_stream.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include "format/checksum.h"
#include "format/field_stream.h"
#include "format/file_names.h"
#include "format/planes.h"
#include "format/view_faces.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

namespace io = boost::iostreams;

constexpr char kViewMagic[] = "plaitvew";
constexpr std::uint32_t kViewFormat = 3;
constexpr std::uint64_t kViewHeaderBytes = 120, kViewChecksumBytes = 8;
constexpr std::uint64_t kMostTableBytes = 1 << 24;
constexpr int kMostViewLevels = 20;
constexpr std::size_t kMostNameBytes = 255;
/// Positions are multiples of 1/32767 of the longest side of their box.
constexpr double kLatticeSteps = 32767;
/// An error byte q > 0 stands for the largest error times 2^((q - 255) / 2).
constexpr double kErrorStepsPerOctave = 2;

/// Bytes of the content before the depths and errors, and all of them.
std::uint64_t mesh_bytes(std::uint64_t vertices, std::uint64_t faces, std::uint64_t far_corners) {
  return faces + 4 * far_corners + 16 * vertices;
}
std::uint64_t content_bytes(std::uint64_t vertices, std::uint64_t faces, std::uint64_t levels,
                            std::uint64_t far_corners, bool has_depths) {
  return mesh_bytes(vertices, faces, far_corners) + (levels + (has_depths ? 1 : 0)) * faces;
}

/// The byte of a face in the view's depths: levels of the positions that the face has.
std::byte depth_byte(std::uint8_t depth, std::uint64_t levels) {
  return static_cast<std::byte>(std::min<std::uint64_t>(depth, levels));
}

std::vector<char> deflate(std::span<const std::byte> bytes) {
  std::vector<char> packed;
  io::filtering_ostream stream;
  stream.push(io::zlib_compressor(io::zlib_params(io::zlib::best_compression)));
  stream.push(io::back_inserter(packed));
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  stream.reset();
  return packed;
}

/// Nothing unless the bytes are a zlib stream of exactly `size` bytes.
std::optional<std::vector<std::byte>> inflate(std::span<const std::byte> packed,
                                              std::uint64_t size) {
  std::vector<std::byte> bytes(size + 1);
  io::filtering_istream stream;
  stream.push(io::zlib_decompressor());
  stream.push(io::array_source(reinterpret_cast<const char*>(packed.data()), packed.size()));
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (stream.bad() || static_cast<std::uint64_t>(stream.gcount()) != size) return std::nullopt;
  bytes.resize(size);
  return bytes;
}

std::byte error_byte(float error, double largest) {
  if (!(error > 0)) return std::byte{0};
  const double octaves = std::log2(static_cast<double>(error) / largest);
  return static_cast<std::byte>(
      std::clamp(std::ceil(255 + kErrorStepsPerOctave * octaves), 1.0, 255.0));
}

std::vector<std::byte> pack_table(const View& view) {
  FieldWriter table;
  table.put(view.position);
  table.put(static_cast<std::uint32_t>(view.attributes.size()));
  for (const ViewAttribute& attribute : view.attributes) {
    table.put_text(attribute.schema.name, kMostNameBytes, "an attribute's name");
    table.put(static_cast<std::uint8_t>(attribute.schema.type));
    table.put(static_cast<std::uint8_t>(attribute.schema.components));
    table.put_text(attribute.base_file, kMostNameBytes, "a file's name");
    table.put(static_cast<std::uint32_t>(attribute.level_files.size()));
    for (const std::string& file : attribute.level_files)
      table.put_text(file, kMostNameBytes, "a file's name");
  }
  return table.take();
}

/// The lattice on which the positions lie.
struct Lattice {
  std::array<double, 3> origin;
  double step;

  explicit Lattice(std::span<const Vector3<double>> positions) {
    std::array<double, 3> high;
    origin.fill(std::numeric_limits<double>::infinity());
    high.fill(-std::numeric_limits<double>::infinity());
    for (const Vector3<double>& position : positions)
      for (int axis = 0; axis < 3; ++axis) {
        if (!std::isfinite(position[axis]))
          throw Error(ErrorCode::kInvalidArgument,
                      "view: a position of a base vertex is no number");
        const auto at = static_cast<std::size_t>(axis);
        origin[at] = std::min(origin[at], position[axis]);
        high[at] = std::max(high[at], position[axis]);
      }
    double side = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) side = std::max(side, high[axis] - origin[axis]);
    step = side > 0 ? side / kLatticeSteps : 1;
  }
  std::array<std::uint32_t, 3> of(const Vector3<double>& position) const {
    std::array<std::uint32_t, 3> place;
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<std::size_t>(axis);
      place[at] = static_cast<std::uint32_t>(std::lround((position[axis] - origin[at]) / step));
    }
    return place;
  }
};

/// Corners, numbers, and coordinates in the order of places: each as the difference to the vertex
/// that the corner before names.
std::vector<std::byte> pack_content(const View& view, const BaseMesh& mesh,
                                    const ViewFaces& corners, const Lattice& lattice,
                                    std::span<const Vector3<double>> positions, double largest) {
  const std::size_t vertices = mesh.vertex_count(), faces = mesh.face_count();
  std::vector<std::byte> content = corners.classes;
  const std::size_t far = corners.distances.size();
  content.resize(
      content_bytes(vertices, faces, view.errors.size() / faces, far, !view.depths.empty()));
  std::byte* to = content.data() + faces;
  const Planes<std::uint32_t> of_far(far), planes(vertices);
  for (std::size_t i = 0; i < far; ++i) of_far.put(to, i, corners.distances[i]);
  to += of_far.bytes();
  VertexId last = 0;
  for (std::size_t i = 0; i < vertices; ++i)
    planes.put(to, i, zigzag(corners.vertices[i] - std::exchange(last, corners.vertices[i])));
  to += planes.bytes();
  std::vector<bool> named(vertices);
  std::array<std::uint32_t, 3> before{};
  std::size_t place = 0;
  for (const auto& face : mesh.faces())
    for (const VertexId vertex : face) {
      const std::array<std::uint32_t, 3> at = lattice.of(positions[vertex]);
      if (!named[vertex]) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          planes.put(to + axis * planes.bytes(), place, zigzag(at[axis] - before[axis]));
        named[vertex] = true;
        ++place;
      }
      before = at;
    }
  to += 3 * planes.bytes();
  for (std::size_t face = 0; face < view.depths.size(); ++face)
    *to++ = depth_byte(view.depths[face], view.errors.size() / faces);
  std::byte* const errors = to;
  for (std::size_t i = 0; i < view.errors.size(); ++i)
    errors[i] = error_byte(view.errors[i], largest);
  // The coarser depth of the same face, or at the first depth the face before, is a good guess.
  for (std::size_t i = view.errors.size(); i-- > 1;) {
    const std::byte guess = i >= faces ? errors[i - faces] : errors[i - 1];
    errors[i] =
        static_cast<std::byte>(std::to_integer<int>(errors[i]) - std::to_integer<int>(guess));
  }
  return content;
}

template <class Number>
void put(std::vector<std::byte>& bytes, std::size_t at, Number number) {
  save(std::span(bytes), at, number);
}

}  // namespace

std::vector<std::byte> encode_view(const View& view, const BaseMesh& mesh,
                                   std::span<const Vector3<double>> positions) {
  const Lattice lattice(positions);
  const std::vector<std::byte> table = pack_table(view);
  const double largest = view.errors.empty() ? 0 : *std::ranges::max_element(view.errors);
  const ViewFaces corners = pack_view_faces(mesh);
  const std::vector<char> packed =
      deflate(pack_content(view, mesh, corners, lattice, positions, largest));
  std::vector<std::byte> bytes(kViewHeaderBytes);
  std::memcpy(bytes.data(), kViewMagic, 8);
  put(bytes, 8, kViewFormat);
  put(bytes, 12, static_cast<std::uint32_t>(view.errors.size() / mesh.face_count()));
  std::memcpy(&bytes[16], view.store.data(), view.store.size());
  put(bytes, 32, view.version);
  put(bytes, 40, std::uint64_t{mesh.vertex_count()});
  put(bytes, 48, std::uint64_t{mesh.face_count()});
  put(bytes, 56, static_cast<std::uint16_t>(view.base_level));
  put(bytes, 58, static_cast<std::uint16_t>(view.depths.empty() ? 0 : 1));
  put(bytes, 60, static_cast<std::uint32_t>(corners.distances.size()));
  for (std::size_t axis = 0; axis < 3; ++axis) put(bytes, 64 + 8 * axis, lattice.origin[axis]);
  put(bytes, 88, lattice.step);
  put(bytes, 96, largest);
  put(bytes, 104, std::uint64_t{table.size()});
  put(bytes, 112, std::uint64_t{packed.size()});
  bytes.resize(kViewHeaderBytes + table.size() + packed.size());
  std::ranges::copy(table, bytes.begin() + kViewHeaderBytes);
  std::ranges::copy(std::as_bytes(std::span(packed)),
                    bytes.end() - static_cast<std::ptrdiff_t>(packed.size()));
  const std::uint64_t checksum = checksum_of(bytes);
  bytes.resize(bytes.size() + kViewChecksumBytes);
  put(bytes, bytes.size() - kViewChecksumBytes, checksum);
  return bytes;
}

void check_view(std::span<const std::byte> bytes, const std::filesystem::path& path,
                const ViewedStore& expected) {
  const std::uint64_t face_count = expected.face_count;
  const auto require = [&](bool right, const std::string& reason) {
    if (!right)
      throw Error(ErrorCode::kCorruption, fmt::format("read {}: {}", path.native(), reason))
          .about(path);
  };
  require(bytes.size() >= kViewHeaderBytes + kViewChecksumBytes,
          fmt::format("{} bytes, expected at least {}", bytes.size(),
                      kViewHeaderBytes + kViewChecksumBytes));
  const std::size_t end = bytes.size() - kViewChecksumBytes;
  require(
      std::memcmp(bytes.data(), kViewMagic, 8) == 0 && load<std::uint32_t>(bytes, 8) == kViewFormat,
      "the header is not that of a view");
  const std::uint64_t found = checksum_of(bytes.first(end)),
                      written = load<std::uint64_t>(bytes, end);
  require(found == written, fmt::format("checksum {:016x}, expected {:016x}", found, written));
  const auto levels = load<std::uint32_t>(bytes, 12);
  const auto table_bytes = load<std::uint64_t>(bytes, 104),
             packed_bytes = load<std::uint64_t>(bytes, 112);
  require(std::memcmp(&bytes[16], expected.uuid.data(), expected.uuid.size()) == 0 &&
              load<std::uint64_t>(bytes, 40) == expected.vertex_count &&
              load<std::uint64_t>(bytes, 48) == face_count && levels <= kMostViewLevels,
          "it is the view of another store");
  require(table_bytes <= kMostTableBytes && packed_bytes <= end &&
              kViewHeaderBytes + table_bytes + packed_bytes == end,
          fmt::format("{} bytes, expected {}", bytes.size(),
                      kViewHeaderBytes + table_bytes + packed_bytes + kViewChecksumBytes));
  // One byte of zlib stands for at most 1032.
  const auto far_corners = load<std::uint32_t>(bytes, 60);
  require(far_corners <= 3 * face_count,
          fmt::format("{} far corners of {} faces", far_corners, face_count));
  const auto has_depths = load<std::uint16_t>(bytes, 58);
  require(has_depths == (expected.depths.empty() ? 0 : 1),
          fmt::format("{} for whether faces have depths of their own, expected {}", has_depths,
                      expected.depths.empty() ? 0 : 1));
  const std::uint64_t size =
      content_bytes(expected.vertex_count, face_count, levels, far_corners, has_depths != 0);
  require(packed_bytes >= size / 1032, "its content is longer than its bytes can be");
  const std::optional<std::vector<std::byte>> content =
      inflate(bytes.subspan(kViewHeaderBytes + table_bytes, packed_bytes), size);
  require(content.has_value(), fmt::format("its content has not {} bytes", size));
  const std::byte* const depths =
      content->data() + mesh_bytes(expected.vertex_count, face_count, far_corners);
  for (std::size_t face = 0; face < expected.depths.size(); ++face)
    require(depths[face] == depth_byte(expected.depths[face], levels),
            fmt::format("depth {} of face {}, expected {}", std::to_integer<int>(depths[face]),
                        face, std::to_integer<int>(depth_byte(expected.depths[face], levels))));
}

std::uint64_t view_version(std::span<const std::byte> bytes) {
  return load<std::uint64_t>(bytes, 32);
}

std::vector<std::byte> read_view_file(const Directory& store, const ViewedStore& expected) {
  const std::optional<File> file = open_if_present(store, kViewName, OpenMode::kRead);
  if (!file) return {};
  const std::uint64_t most = kViewHeaderBytes + kMostTableBytes + kViewChecksumBytes +
                             2 * content_bytes(expected.vertex_count, expected.face_count,
                                               kMostViewLevels, 3 * expected.face_count, true);
  if (file->size() > most)
    throw Error(ErrorCode::kCorruption, fmt::format("read {}: {} bytes, expected at most {}",
                                                    file->path().native(), file->size(), most))
        .about(file->path());
  std::vector<std::byte> bytes(file->size());
  file->read_at(0, bytes);
  check_view(bytes, file->path(), expected);
  return bytes;
}

PLAIT_END_NAMESPACE
