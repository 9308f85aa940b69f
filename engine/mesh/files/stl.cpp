// STL: triangles with three positions each, text (stl_text.cpp) or binary. Corners with equal
// positions are one vertex. Source: 3D Systems, "StereoLithography Interface Specification", 1989.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <optional>
#include <string_view>
#include <utility>

#include "mesh/connectivity.h"
#include "mesh/files/readers.h"
#include "mesh/files/stl_text.h"
#include "mesh/position_table.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

/// The number of 32 bits at `at`. REQUIRES: it is in the buffer.
std::uint32_t load_word(const Input& input, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t byte = 4; byte-- > 0;)
    value = value << 8 | static_cast<unsigned char>(input.unread()[at + byte]);
  return value;
}

bool has_word(std::string_view text, std::string_view word) {
  return std::search(text.begin(), text.end(), word.begin(), word.end(), [](char a, char b) {
           return std::tolower(static_cast<unsigned char>(a)) == b;
         }) != text.end();
}

/// A binary file has bytes in its first facet that no text has: numbers of a normal are 0 or have
/// such bytes, and the two bytes behind the facet are 0 as a rule. A name may have such bytes too,
/// but then the words of a facet follow, which no binary file has where its first facets are.
bool looks_like_text(Input& input) {
  constexpr std::size_t kLookBytes = kHeaderBytes + 2 * kFacetBytes;
  input.ensure(kLookBytes);
  const std::string_view facets = input.unread().substr(0, kLookBytes);
  if (has_word(facets, "facet") && has_word(facets, "vertex")) return true;
  for (const char c : input.unread().substr(0, kLookBytes))
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0 &&
        std::isspace(static_cast<unsigned char>(c)) == 0)
      return false;
  return true;
}

class StlReader {
 public:
  StlReader(Input& input, Reading& reading) : input_(input), reading_(reading) {}

  AttributedMesh read() {
    const bool text = !is_binary_stl(input_) && looks_like_text(input_);
    text ? read_text() : read_binary();
    AttributedMesh result{std::move(mesh_)};
    if (!text) result.precision = ComponentType::kFloat32;
    return result;
  }

 private:
  using Corners = std::array<Vector3<double>, 3>;

  void add(const Corners& corners) {
    std::array<VertexId, 3> face;
    for (std::size_t at = 0; at < 3; ++at) {
      const auto next = static_cast<VertexId>(mesh_.positions.size());
      // -0 becomes 0, which is equal.
      const Vector3<double> position = corners[at] + Vector3<double>{0, 0, 0};
      face[at] = vertices_.find_or_add(position, next);
      if (face[at] == next) mesh_.positions.push_back(position);
    }
    mesh_.faces.push_back(face);
  }

  void read_binary();
  void read_text();

  Input& input_;
  Reading& reading_;
  IndexedMesh mesh_;
  PositionTable vertices_{mesh_.positions};
};

void StlReader::read_binary() {
  if (!input_.ensure(kHeaderBytes))
    input_.refuse_at_byte(input_.offset(), "expected a header of 84 bytes, found the end");
  const std::uint64_t count = load_word(input_, kHeaderBytes - 4);
  // Counts of 2^24 and more whose bytes all stand for characters; UTF-16 has zeros between them.
  const bool count_is_text =
      count >= (1u << 24) &&
      std::ranges::all_of(input_.unread().substr(kHeaderBytes - 4, 4), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte == 0 || std::isprint(byte) != 0 || std::isspace(byte) != 0;
      });
  // The same by default, as Materialise Magics writes it: COLOR=rgba and MATERIAL=.
  const std::string_view header = input_.unread().substr(0, kHeaderBytes - 4);
  const std::uint64_t of_part = header.find("COLOR=") != std::string_view::npos ||
                                header.find("MATERIAL=") != std::string_view::npos;
  input_.consume(kHeaderBytes);
  if (count > kMaxFaces && !count_is_text)
    input_.refuse_at_byte(80,
                          fmt::format("expected at most {} facets, found {}", kMaxFaces, count));
  mesh_.faces.reserve(input_.plausible_count(count, kFacetBytes));
  std::uint64_t with_bytes = 0;
  for (std::uint64_t facet = 0; facet < count; ++facet) {
    if (!input_.ensure(kFacetBytes) && count_is_text)
      input_.refuse_at_byte(0,
                            "expected a text with facets or a binary STL file, found neither: the "
                            "file has no facets for what bytes 80 to 83 count, which are text");
    if (!input_.ensure(kFacetBytes))
      input_.refuse_at_byte(
          input_.offset() + input_.unread().size(),
          fmt::format("facet {}: expected all {} of them, found the end", facet, count));
    Corners corners{};
    for (std::size_t number = 0; number < 9; ++number) {
      const std::size_t at = 12 + 4 * number;
      const auto value = std::bit_cast<float>(load_word(input_, at));
      if (!input_.takes(value))
        input_.refuse_at_byte(
            input_.offset() + at,
            fmt::format("facet {}: expected a finite number, found {}", facet, value));
      corners[number / 3][static_cast<int>(number % 3)] = value;
    }
    add(corners);
    with_bytes += input_.unread()[kFacetBytes - 2] != 0 || input_.unread()[kFacetBytes - 1] != 0;
    input_.consume(kFacetBytes);
  }
  if (input_.ensure(1))
    input_.refuse_at_byte(input_.offset(),
                          fmt::format("expected the end after {} facets, found more", count));
  reading_.leave_out(of_part, "colour or material of the whole part, in the header", "");
  reading_.leave_out_of("attribute bytes (colours of some programs)", with_bytes, "facet",
                        "facets");
}

void StlReader::read_text() {
  StlText text(input_);
  for (Corners corners{}; text.next_facet(corners);) {
    if (mesh_.faces.size() == kMaxFaces) text.refuse(fmt::format("at most {} facets", kMaxFaces));
    add(corners);
  }
  if (text.solids() > 1)
    reading_.warn(
        fmt::format("{}: {} solids read as one mesh", input_.path().native(), text.solids()));
  if (!text.has_end())
    reading_.warn(fmt::format("{}: the last solid has no endsolid: the file may be cut short",
                              input_.path().native()));
}

}  // namespace

bool is_binary_stl(Input& input) {
  if (!input.ensure(kHeaderBytes)) return false;
  const std::uint64_t size =
      kHeaderBytes + std::uint64_t{kFacetBytes} * load_word(input, kHeaderBytes - 4);
  if (const std::optional<std::uint64_t> known = input.content_bytes()) return size == *known;
  return false;
}

AttributedMesh read_stl(Input& input, Reading& reading) { return StlReader(input, reading).read(); }

PLAIT_END_NAMESPACE
