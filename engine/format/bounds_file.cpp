#include "format/bounds_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "format/byte_order.h"
#include "format/checksum.h"
#include "format/file_names.h"
#include "plait/error.h"
#include "plait/extend/file.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr char kBoundsMagic[] = "plaitbox";
constexpr std::uint32_t kFormat = 1;
constexpr std::uint64_t kBoundsHeaderBytes = 32, kChecksumBytes = 8;
/// Room for what the file has before and after the bounds.
constexpr std::uint64_t kEntriesBeside = 2;
static_assert(kEntriesBeside * sizeof(FaceBounds) >= kBoundsHeaderBytes + kChecksumBytes);

std::uint64_t bounds_file_bytes(std::uint64_t face_count) {
  return kBoundsHeaderBytes + face_count * sizeof(FaceBounds) + kChecksumBytes;
}

struct Stored {
  std::uint64_t key;
  std::vector<FaceBounds> faces;
};

/// Nothing if there is no file.
std::optional<Stored> read_file(const Directory& store, std::uint32_t attribute,
                                std::uint64_t face_count) {
  const std::string name = bounds_file_name(attribute);
  const std::optional<File> opened = open_if_present(store, name, OpenMode::kRead);
  if (!opened) return std::nullopt;
  const File& file = *opened;
  const auto refuse = [&](const std::string& reason) {
    return Error(ErrorCode::kCorruption, fmt::format("read {}: {}", file.path().native(), reason))
        .about(file.path());
  };
  if (file.size() != bounds_file_bytes(face_count))
    throw refuse(fmt::format("{} bytes, expected {} for {} faces", file.size(),
                             bounds_file_bytes(face_count), face_count));
  // The whole file is read into the memory that its bounds take in the end: a second copy would
  // leave a hole in the heap that is as large.
  std::vector<FaceBounds> faces(face_count + kEntriesBeside);
  const std::span<std::byte> bytes =
      std::as_writable_bytes(std::span(faces)).first(bounds_file_bytes(face_count));
  file.read_at(0, bytes);
  const std::size_t content = bytes.size() - kChecksumBytes;
  const std::uint64_t found = checksum_of(std::span(bytes).first(content));
  if (const auto expected = load<std::uint64_t>(bytes, content); found != expected)
    throw refuse(fmt::format("checksum {:016x}, expected {:016x}", found, expected));
  if (std::memcmp(bytes.data(), kBoundsMagic, 8) != 0 || load<std::uint32_t>(bytes, 8) != kFormat ||
      load<std::uint64_t>(bytes, 16) != face_count)
    throw refuse("the header is not that of bounds of these faces");
  const auto key = load<std::uint64_t>(bytes, 24);
  std::memmove(bytes.data(), &bytes[kBoundsHeaderBytes], face_count * sizeof(FaceBounds));
  faces.resize(face_count);
  for (FaceId face = 0; face < face_count; ++face)
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (std::isnan(faces[face].low[axis]) || std::isnan(faces[face].high[axis]))
        throw refuse(fmt::format("a bound of face {} is not a number", face));
  return Stored{key, std::move(faces)};
}

}  // namespace

std::uint64_t bounds_key(const StoreUuid& store, std::uint32_t attribute,
                         std::uint64_t base_checksum, std::span<const BlockTable* const> tables) {
  std::vector<std::byte> bytes(store.begin(), store.end());
  const auto put = [&](auto value) {
    bytes.resize(bytes.size() + sizeof(value));
    save(std::span(bytes), bytes.size() - sizeof(value), value);
  };
  put(attribute);
  put(static_cast<std::uint32_t>(tables.size()));
  put(base_checksum);
  for (const BlockTable* const table : tables)
    for (const BlockEntry& block : table->entries()) put(block.checksum);
  return checksum_of(bytes);
}

std::optional<std::vector<FaceBounds>> read_bounds_file(const Directory& store,
                                                        std::uint32_t attribute,
                                                        std::uint64_t face_count,
                                                        std::uint64_t key) {
  std::optional<Stored> stored = read_file(store, attribute, face_count);
  if (!stored || stored->key != key) return std::nullopt;
  return std::move(stored->faces);
}

void check_bounds_file(const Directory& store, std::uint32_t attribute, std::uint64_t face_count) {
  read_file(store, attribute, face_count);
}

void write_bounds_file(const Directory& store, std::uint32_t attribute,
                       std::span<const FaceBounds> faces, std::uint64_t key) {
  std::vector<std::byte> bytes(bounds_file_bytes(faces.size()));
  std::memcpy(bytes.data(), kBoundsMagic, 8);
  save(std::span(bytes), 8, kFormat);
  save(std::span(bytes), 16, static_cast<std::uint64_t>(faces.size()));
  save(std::span(bytes), 24, key);
  if (!faces.empty()) std::memcpy(&bytes[kBoundsHeaderBytes], faces.data(), faces.size_bytes());
  const std::size_t content = bytes.size() - kChecksumBytes;
  save(std::span(bytes), content, checksum_of(std::span(bytes).first(content)));
  const std::string name = bounds_file_name(attribute), made = new_bounds_file_name(attribute);
  store.remove(made);  // a killed process may have left it
  try {
    File file(store, made, OpenMode::kCreate);
    file.write_at(0, bytes);
    file.sync();
    file.close();
    store.rename(made, store, name);
    store.sync();
  } catch (...) {
    store.remove_if_possible(made);
    throw;
  }
}

PLAIT_END_NAMESPACE
