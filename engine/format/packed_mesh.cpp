#include "format/packed_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "format/number_places.h"
#include "format/planes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A corner is one of these: a vertex that no corner before it has named; corner a, b or c of the
/// face before; or, from kBehind on, the vertex that is 1, 2, ... behind the next new one
/// in the order in which corners name vertices.
constexpr std::uint32_t kNew = 0, kCornerBefore = 1, kBehind = 4;

constexpr double Vector3<double>::*kCoordinates[] = {&Vector3<double>::x, &Vector3<double>::y,
                                                     &Vector3<double>::z};

/// Whole numbers below this one take three bytes.
constexpr double kMostWhole = 1 << 24;

template <class Number>
struct Places {
  using Word = WordOf<Number>;
  explicit Places(PositionWords /*words*/) {}
  Word word(double x) const { return place_of(static_cast<Number>(x)); }
  double number(Word word) const { return number_at<Number>(word); }
};
struct Wholes {
  using Word = std::uint32_t;
  explicit Wholes(PositionWords words)
      : unit(std::ldexp(1.0, words.exponent)), inverse(std::ldexp(1.0, -words.exponent)) {}
  Word word(double x) const { return static_cast<Word>(static_cast<std::int32_t>(x * inverse)); }
  double number(Word word) const { return static_cast<std::int32_t>(word) * unit; }
  double unit, inverse;  ///< powers of two, so products are exact
};

/// Calls work(coder) with what makes words of coordinates.
template <class Work>
void with_coder(PositionWords words, Work work) {
  if (words.form == PositionForm::kFloat32) return work(Places<float>(words));
  if (words.form == PositionForm::kFloat64) return work(Places<double>(words));
  work(Wholes(words));
}

/// The largest e for which x is a multiple of 2^e. REQUIRES: x is finite and not 0.
int exponent_of_lowest_bit(double x) {
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  const auto digits =
      static_cast<std::int64_t>(std::ldexp(fraction, std::numeric_limits<double>::digits));
  return exponent - std::numeric_limits<double>::digits +
         std::countr_zero(static_cast<std::uint64_t>(digits));
}

/// Adds coordinates, each as the difference to that of the place before: planes of each coordinate.
template <class Coder>
void put_coordinates(const Coder& coder, std::span<const Vector3<double>> positions,
                     std::span<const std::uint32_t> vertices, std::byte* to) {
  using Word = typename Coder::Word;
  const Planes<Word> planes(vertices.size());
  for (const auto coordinate : kCoordinates) {
    Word last = 0;
    for (std::size_t place = 0; place < vertices.size(); ++place) {
      const Word word = coder.word(positions[vertices[place]].*coordinate);
      planes.put(to, place, zigzag(static_cast<Word>(word - std::exchange(last, word))));
    }
    to += planes.bytes();
  }
}

template <class Coder>
void take_coordinates(const Coder& coder, const std::byte* from,
                      std::span<const std::uint32_t> vertices,
                      std::vector<Vector3<double>>& positions) {
  using Word = typename Coder::Word;
  const Planes<Word> planes(vertices.size());
  for (const auto coordinate : kCoordinates) {
    Word last = 0;
    planes.for_each(from, [&](std::size_t place, Word difference) {
      last += from_zigzag(difference);
      positions[vertices[place]].*coordinate = coder.number(last);
    });
    from += planes.bytes();
  }
}

}  // namespace

void WordsOfPositions::add(const Vector3<double>& position) {
  for (const auto coordinate : kCoordinates) {
    const double x = position.*coordinate;
    fit_float32_ &= std::isfinite(x) && std::abs(x) <= double{std::numeric_limits<float>::max()} &&
                    double{static_cast<float>(x)} == x;
    whole_ &= std::isfinite(x) && !(x == 0 && std::signbit(x));
    if (!whole_ || x == 0) continue;
    exponent_ = std::min(exponent_, exponent_of_lowest_bit(x));
    largest_ = std::max(largest_, std::abs(x));
  }
}

PositionWords WordsOfPositions::words() const {
  const PositionWords in_steps{PositionForm::kWhole, exponent_};
  if (whole_ && in_steps.valid() && std::ldexp(largest_, -exponent_) < kMostWhole) return in_steps;
  return {fit_float32_ ? PositionForm::kFloat32 : PositionForm::kFloat64, 0};
}

PositionWords words_of(std::span<const Vector3<double>> positions) {
  WordsOfPositions words;
  for (const Vector3<double>& position : positions) words.add(position);
  return words.words();
}

std::uint64_t word_of_coordinate(PositionWords words, double x) {
  std::uint64_t word = 0;
  with_coder(words, [&](const auto& coder) { word = coder.word(x); });
  return word;
}

std::uint32_t CornerCodes::code(std::uint32_t place) {
  std::uint32_t code = kBehind - 1 + next_ - place;
  if (place == next_) {
    ++next_;
    code = kNew;
  } else if (const auto found = std::ranges::find(before_, place); found != before_.end()) {
    code = kCornerBefore + static_cast<std::uint32_t>(found - before_.begin());
  }
  face_[corner_] = place;
  if (++corner_ == face_.size()) {
    before_ = face_;
    corner_ = 0;
  }
  return code;
}

std::vector<std::byte> pack_mesh(const BaseMesh& mesh, PositionWords words) {
  const Planes<std::uint32_t> corners(3 * mesh.face_count()), numbers(mesh.vertex_count());
  std::vector<std::byte> packed(packed_mesh_bytes(mesh.vertex_count(), mesh.face_count(), words));
  std::byte* const to = packed.data();
  const std::span<const std::array<VertexId, 3>> faces = mesh.faces();
  std::byte* const to_numbers = to + corners.bytes();
  std::vector<std::uint32_t> places(mesh.vertex_count(), kNoId);  // in the order of first use
  std::vector<VertexId> vertices(mesh.vertex_count());            // [place]
  CornerCodes codes;
  VertexId last = 0;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (std::size_t i = 0; i < 3; ++i) {
      const VertexId vertex = faces[f][i];
      std::uint32_t& place = places[vertex];
      if (place == kNoId) {
        place = codes.next_place();
        numbers.put(to_numbers, place, zigzag(vertex - std::exchange(last, vertex)));
        vertices[place] = vertex;
      }
      corners.put(to, 3 * f + i, codes.code(place));
    }
  with_coder(words, [&](const auto& coder) {
    put_coordinates(coder, mesh.positions(), vertices, to_numbers + numbers.bytes());
  });
  return packed;
}

std::optional<IndexedMesh> unpack_mesh(std::span<const std::byte> packed,
                                       std::uint64_t vertex_count, std::uint64_t face_count,
                                       PositionWords words) {
  if (vertex_count == 0 && face_count > 0) return std::nullopt;
  const Planes<std::uint32_t> corners(3 * face_count), numbers(vertex_count);
  IndexedMesh mesh;
  mesh.positions.resize(vertex_count);
  mesh.faces.resize(face_count);
  const std::byte* const from = packed.data();
  const std::byte* const from_numbers = from + corners.bytes();
  std::vector<VertexId> vertices(vertex_count);
  VertexId last = 0;
  bool sound = true;
  numbers.for_each(from_numbers, [&](std::size_t place, std::uint32_t difference) {
    last += from_zigzag(difference);
    const bool known = last < vertex_count;
    sound &= known;
    vertices[place] = known ? last : 0;
  });
  // The places that codes below kBehind stand for, in this face and in the next one. Codes are hard
  // to foresee, so the loop looks them up instead of branching.
  std::array<std::uint32_t, kBehind> both[2] = {{0, kNoId, kNoId, kNoId}, {}};
  std::uint32_t next = 0;
  std::size_t f = 0, i = 0;
  corners.for_each(from, [&](std::size_t, std::uint32_t corner) {
    auto& places = both[f % 2];
    places[kNew] = next;
    // What is too far behind wraps to a large number.
    const std::uint32_t place = corner < kBehind ? places[corner] : next + (kBehind - 1) - corner;
    next += corner == kNew ? 1 : 0;
    const bool known = place < next && next <= vertex_count;
    sound &= known;
    mesh.faces[f][i] = vertices[known ? place : 0];
    both[1 - f % 2][kCornerBefore + i] = place;
    if (++i == 3) ++f, i = 0;
  });
  if (!sound || next != vertex_count) return std::nullopt;
  with_coder(words, [&](const auto& coder) {
    take_coordinates(coder, from_numbers + numbers.bytes(), vertices, mesh.positions);
  });
  return mesh;
}

std::vector<std::byte> pack_maps(const InputMaps& maps) {
  const std::size_t vertices = maps.input_vertices.size(), faces = maps.input_faces.size();
  std::vector<std::byte> packed(packed_maps_bytes(vertices, faces));
  const Planes<std::uint32_t> of_vertices(vertices), of_faces(faces);
  std::uint32_t last = 0;
  for (std::size_t v = 0; v < vertices; ++v)
    of_vertices.put(packed.data(), v,
                    zigzag(maps.input_vertices[v] - std::exchange(last, maps.input_vertices[v])));
  last = 0;
  for (std::size_t f = 0; f < faces; ++f) {
    const std::uint32_t code = 2 * maps.input_faces[f] + (maps.turned[f] ? 1 : 0);
    of_faces.put(packed.data() + of_vertices.bytes(), f, zigzag(code - std::exchange(last, code)));
  }
  return packed;
}

InputMaps unpack_maps(std::span<const std::byte> packed, std::uint64_t vertex_count,
                      std::uint64_t face_count, std::uint64_t input_vertex_count) {
  const Planes<std::uint32_t> of_vertices(vertex_count), of_faces(face_count);
  InputMaps maps;
  maps.input_vertices.resize(vertex_count);
  maps.input_faces.resize(face_count);
  maps.turned.resize(face_count);
  maps.input_vertex_count = input_vertex_count;
  std::uint32_t last = 0;
  of_vertices.for_each(packed.data(), [&](std::size_t v, std::uint32_t difference) {
    maps.input_vertices[v] = last += from_zigzag(difference);
  });
  last = 0;
  of_faces.for_each(packed.data() + of_vertices.bytes(),
                    [&](std::size_t f, std::uint32_t difference) {
                      last += from_zigzag(difference);
                      maps.input_faces[f] = last / 2;
                      maps.turned[f] = last % 2 != 0;
                    });
  return maps;
}

PLAIT_END_NAMESPACE
