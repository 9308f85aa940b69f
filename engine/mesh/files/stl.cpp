// STL: triangles with three positions each, text or binary. Corners with equal positions are one
// vertex. Source: 3D Systems, "StereoLithography Interface Specification", 1989.

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "mesh/connectivity.h"
#include "mesh/files/readers.h"
#include "mesh/files/text_input.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Corner = std::array<float, 3>;

/// Finds the vertex of a position. A hash table with open addressing: a power of two of places, at
/// most half of which are taken.
class VertexWelder {
 public:
  explicit VertexWelder(std::vector<Vector3<double>>& positions) : positions_(positions) {}

  VertexId find_or_add(Corner at) {
    for (float& number : at) number += 0.0f;  // -0 becomes 0, which is equal
    if (2 * (positions_.size() + 1) > places_.size()) grow();
    for (std::size_t place = hash(at) & mask();; place = (place + 1) & mask()) {
      VertexId& vertex = places_[place];
      if (vertex == kNoId) {
        vertex = static_cast<VertexId>(positions_.size());
        positions_.push_back({at[0], at[1], at[2]});
        return vertex;
      }
      if (bits_of(corner_of(vertex)) == bits_of(at)) return vertex;
    }
  }

 private:
  std::size_t mask() const { return places_.size() - 1; }
  Corner corner_of(VertexId vertex) const {
    const Vector3<double>& p = positions_[vertex];
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
  /// Coordinates that are no numbers differ from themselves, and their bits do not.
  static std::array<std::uint32_t, 3> bits_of(const Corner& at) {
    return std::bit_cast<std::array<std::uint32_t, 3>>(at);
  }
  /// S. Vigna, "splitmix64", 2015: its mixing step.
  static std::size_t hash(const Corner& at) {
    std::uint64_t value = 0;
    for (const float number : at) {
      value = (value + std::bit_cast<std::uint32_t>(number)) * 0x9e3779b97f4a7c15u;
      value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    }
    return value ^ (value >> 31);
  }
  void grow() {
    places_.assign(std::max<std::size_t>(1024, 2 * places_.size()), kNoId);
    for (VertexId vertex = 0; vertex < positions_.size(); ++vertex) {
      std::size_t place = hash(corner_of(vertex)) & mask();
      while (places_[place] != kNoId) place = (place + 1) & mask();
      places_[place] = vertex;
    }
  }

  std::vector<Vector3<double>>& positions_;
  std::vector<VertexId> places_;
};

class StlReader {
 public:
  explicit StlReader(Input& input) : input_(input) {}

  IndexedMesh read() {
    is_text() ? read_text() : read_binary();
    return std::move(mesh_);
  }

 private:
  static constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50;

  /// A binary file may begin with "solid" too, but then no facet follows as a word.
  bool is_text() {
    constexpr std::size_t kLookBytes = 1024;
    input_.ensure(kLookBytes);
    const std::string_view start = input_.unread().substr(0, kLookBytes);
    const bool has_words = start.find("facet") != std::string_view::npos ||
                           start.find("endsolid") != std::string_view::npos;
    return start.starts_with("solid") && has_words && start.find('\0') == std::string_view::npos;
  }

  void add(const std::array<Corner, 3>& corners) {
    std::array<VertexId, 3> face;
    for (std::size_t at = 0; at < 3; ++at) face[at] = welder_.find_or_add(corners[at]);
    mesh_.faces.push_back(face);
  }

  void read_binary() {
    if (!input_.ensure(kHeaderBytes))
      input_.refuse_at_byte(input_.offset(), "expected a header of 84 bytes, found the end");
    const auto load = [&](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t byte = 4; byte-- > 0;)
        value = value << 8 | static_cast<unsigned char>(input_.unread()[at + byte]);
      return value;
    };
    const std::uint64_t count = load(80);
    input_.consume(kHeaderBytes);
    if (count > kMaxFaces)
      input_.refuse_at_byte(80,
                            fmt::format("expected at most {} facets, found {}", kMaxFaces, count));
    mesh_.faces.reserve(input_.plausible_count(count, kFacetBytes));
    for (std::uint64_t facet = 0; facet < count; ++facet) {
      if (!input_.ensure(kFacetBytes))
        input_.refuse_at_byte(
            input_.offset() + input_.unread().size(),
            fmt::format("facet {}: expected all {} of them, found the end", facet, count));
      std::array<Corner, 3> corners;
      for (std::size_t number = 0; number < 9; ++number) {
        const float value = std::bit_cast<float>(load(12 + 4 * number));
        if (!input_.takes(value))
          input_.refuse_at_byte(
              input_.offset() + 12 + 4 * number,
              fmt::format("facet {}: expected a finite number, found {}", facet, value));
        corners[number / 3][number % 3] = value;
      }
      add(corners);
      input_.consume(kFacetBytes);
    }
    if (input_.ensure(1))
      input_.refuse_at_byte(input_.offset(),
                            fmt::format("expected the end after {} facets, found more", count));
  }

  void read_text() {
    TextInput text(input_, TextRules{});
    std::array<Corner, 3> corners;
    std::size_t found = 0;
    while (text.next_line()) {
      const std::string_view word = text.word();
      const std::string element = fmt::format("facet {}", mesh_.faces.size());
      if (word == "vertex") {
        if (found == 3) text.refuse(element, "three vertices", "another one");
        for (float& number : corners[found]) {
          const std::string_view digits = text.word();
          const std::optional<double> value = parse_number(digits);
          number = static_cast<float>(value.value_or(0));
          if (!value || !input_.takes(number)) text.refuse(element, "a finite number", digits);
        }
        ++found;
      } else if (word == "endfacet") {
        if (found != 3) text.refuse(element, "three vertices", fmt::format("{}", found));
        if (mesh_.faces.size() == kMaxFaces)
          text.refuse(element, fmt::format("at most {} facets", kMaxFaces), "more");
        add(corners);
        found = 0;
      } else if (word != "solid" && word != "facet" && word != "outer" && word != "endloop" &&
                 word != "endsolid") {
        text.refuse(element, "a word of STL", word);
      }
    }
    if (found != 0) text.refuse_end(fmt::format("facet {}", mesh_.faces.size()), "endfacet");
  }

  Input& input_;
  IndexedMesh mesh_;
  VertexWelder welder_{mesh_.positions};
};

}  // namespace

IndexedMesh read_stl(Input& input, Warnings*) { return StlReader(input).read(); }

PLAIT_END_NAMESPACE
