// OFF: vertices and faces of a Geomview file, one to a line. The reader skips normals, colours and
// texture coordinates after a position, and colours after a face.
// Source: The Geometry Center, "Geomview manual", chapter 4.2.5, 1996.

#include <fmt/format.h>

#include "mesh/connectivity.h"
#include "mesh/files/readers.h"
#include "mesh/files/text_input.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class OffReader {
 public:
  explicit OffReader(Input& input) : text_(input, {.hash_comments = true}) {}

  IndexedMesh read(Warnings* warnings) {
    read_header();
    mesh_.positions.reserve(text_.input().plausible_count(vertex_count_, kLeastLineBytes));
    for (std::uint64_t vertex = 0; vertex < vertex_count_; ++vertex) read_vertex(vertex);
    mesh_.faces.reserve(text_.input().plausible_count(face_count_, kLeastLineBytes));
    for (std::uint64_t face = 0; face < face_count_; ++face) read_face(face);
    if (text_.next_line())
      text_.refuse("end", fmt::format("nothing after {} faces", face_count_), text_.word());
    divider_.report(text_.input(), warnings);
    return std::move(mesh_);
  }

 private:
  /// The shortest line: three numbers of one digit, two blanks and a line end.
  static constexpr std::uint64_t kLeastLineBytes = 6;
  static constexpr std::string_view kVertexCount = "a count of vertices";

  void read_header();
  std::uint64_t read_count(std::string_view what, std::uint64_t most);
  std::uint64_t check_count(std::string_view word, std::string_view what, std::uint64_t most) const;
  void begin_line(std::string_view what, std::uint64_t index, std::uint64_t count);
  void pass_numbers(std::string_view what, std::uint64_t index);
  void read_vertex(std::uint64_t vertex);
  void read_face(std::uint64_t face);

  TextInput text_;
  std::uint64_t vertex_count_ = 0, face_count_ = 0;
  IndexedMesh mesh_;
  FaceDivider divider_{mesh_.faces};
};

std::uint64_t OffReader::check_count(std::string_view word, std::string_view what,
                                     std::uint64_t most) const {
  const std::optional<std::int64_t> count = parse_integer(word);
  if (word == "BINARY") text_.refuse("header", "ascii numbers", word);
  if (!count || *count < 0) text_.refuse("header", what, word);
  if (static_cast<std::uint64_t>(*count) > most)
    text_.refuse("header", fmt::format("{} of at most {}", what, most), word);
  return static_cast<std::uint64_t>(*count);
}

std::uint64_t OffReader::read_count(std::string_view what, std::uint64_t most) {
  if (!text_.seek_word()) text_.refuse_end("header", what);
  return check_count(text_.word(), what, most);
}

void OffReader::read_header() {
  if (!text_.seek_word()) text_.refuse_end("header", "OFF");
  const std::string first(text_.word());
  if (is_off_keyword(first)) {
    if (first.find_first_of("4n") != std::string::npos)
      text_.refuse("header", "positions of three dimensions", first);
    vertex_count_ = read_count(kVertexCount, kMaxVertices);
  } else {
    // A file whose name ends in .off may lack the keyword.
    if (!parse_integer(first)) text_.refuse("header", "OFF or a count of vertices", first);
    vertex_count_ = check_count(first, kVertexCount, kMaxVertices);
  }
  face_count_ = read_count("a count of faces", kMaxFaces);
  pass_numbers("count of edges", 0);
}

void OffReader::begin_line(std::string_view what, std::uint64_t index, std::uint64_t count) {
  if (!text_.next_line())
    text_.refuse_end(fmt::format("{} {}", what, index), fmt::format("all {} of them", count));
}

void OffReader::pass_numbers(std::string_view what, std::uint64_t index) {
  for (std::string_view word = text_.word(); !word.empty(); word = text_.word())
    if (!parse_number(word)) text_.refuse(fmt::format("{} {}", what, index), "a number", word);
}

void OffReader::read_vertex(std::uint64_t vertex) {
  begin_line("vertex", vertex, vertex_count_);
  Vector3<double> p{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = text_.word();
    const std::optional<double> number = parse_number(word);
    if (!number || !text_.input().takes(*number))
      text_.refuse(fmt::format("vertex {}", vertex), "a finite number", word);
    p[axis] = *number;
  }
  pass_numbers("vertex", vertex);
  mesh_.positions.push_back(p);
}

void OffReader::read_face(std::uint64_t face) {
  begin_line("face", face, face_count_);
  const auto refuse = [&](std::string_view expected, std::string_view found) {
    text_.refuse(fmt::format("face {}", face), expected, found);
  };
  const std::string_view count_word = text_.word();
  const std::optional<std::int64_t> corners = parse_integer(count_word);
  if (!corners || *corners < 3) refuse("three corners or more", count_word);
  divider_.begin();
  for (std::int64_t corner = 0; corner < *corners; ++corner) {
    const std::string_view word = text_.word();
    const std::optional<std::int64_t> vertex = parse_integer(word);
    if (!vertex || *vertex < 0 || static_cast<std::uint64_t>(*vertex) >= vertex_count_)
      refuse(fmt::format("a vertex below {}", vertex_count_), word);
    if (!divider_.add(static_cast<VertexId>(*vertex)))
      refuse(fmt::format("at most {} triangles", kMaxFaces), "more");
  }
  pass_numbers("face", face);
}

}  // namespace

bool is_off_keyword(std::string_view word) {
  const auto take = [&](std::string_view prefix) {
    if (word.starts_with(prefix) && word != "OFF") word.remove_prefix(prefix.size());
  };
  for (const std::string_view prefix : {"ST", "C", "N", "4", "n"}) take(prefix);
  return word == "OFF";
}

IndexedMesh read_off(Input& input, Warnings* warnings) { return OffReader(input).read(warnings); }

PLAIT_END_NAMESPACE
