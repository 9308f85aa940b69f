// OFF: vertices and faces of a Geomview file, one to a line. Normals, colours and texture
// coordinates after a position, and colours after a face, are counted and left out. Source: The
// Geometry Center, "Geomview manual", chapter 4.2.5, 1996.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mesh/connectivity.h"
#include "mesh/files/face_divider.h"
#include "mesh/files/readers.h"
#include "mesh/files/text_input.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

class OffReader {
 public:
  OffReader(Input& input, Reading& reading)
      : text_(input, {.hash_comments = true}), reading_(reading) {}

  IndexedMesh read() {
    read_header();
    mesh_.positions.reserve(text_.input().plausible_count(vertex_count_, kLeastLineBytes));
    for (std::uint64_t vertex = 0; vertex < vertex_count_; ++vertex) read_vertex(vertex);
    mesh_.faces.reserve(text_.input().plausible_count(face_count_, kLeastLineBytes));
    for (std::uint64_t face = 0; face < face_count_; ++face) read_face(face);
    if (text_.next_line())
      text_.refuse("end", fmt::format("nothing after {} faces", face_count_), text_.word());
    divider_.finish(text_.input(), 0, reading_.warnings);
    reading_.leave_out_of_vertices(kinds_of_numbers(), vertices_with_more_);
    reading_.leave_out_of("colours", faces_with_more_, "face", "faces");
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
  /// Returns how many there are.
  std::uint64_t pass_numbers(std::string_view what, std::uint64_t index);
  std::string kinds_of_numbers() const;
  void read_vertex(std::uint64_t vertex);
  void read_face(std::uint64_t face);

  TextInput text_;
  Reading& reading_;
  std::string keyword_;
  std::uint64_t vertex_count_ = 0, face_count_ = 0;
  std::uint64_t vertices_with_more_ = 0, faces_with_more_ = 0;
  IndexedMesh mesh_;
  FaceDivider divider_{mesh_};
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
  if (const std::size_t bytes = off_keyword_bytes(first); bytes > 0) {
    keyword_ = first.substr(0, bytes);
    if (keyword_.find_first_of("4n") != std::string::npos)
      text_.refuse("header", "positions of three dimensions", first);
    vertex_count_ = bytes < first.size()
                        ? check_count(first.substr(bytes), kVertexCount, kMaxVertices)
                        : read_count(kVertexCount, kMaxVertices);
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

std::uint64_t OffReader::pass_numbers(std::string_view what, std::uint64_t index) {
  std::uint64_t numbers = 0;
  for (std::string_view word = text_.word(); !word.empty(); word = text_.word(), ++numbers)
    if (!parse_number(word)) text_.refuse(fmt::format("{} {}", what, index), "a number", word);
  return numbers;
}

/// By the keyword; without its letters they are colours as a rule.
std::string OffReader::kinds_of_numbers() const {
  std::vector<std::string_view> kinds;
  const std::string_view letters = std::string_view(keyword_).substr(0, keyword_.find("OFF"));
  if (letters.find("ST") != std::string_view::npos) kinds.emplace_back("texture coordinates");
  if (letters.find('N') != std::string_view::npos) kinds.emplace_back("normals");
  if (letters.find('C') != std::string_view::npos || kinds.empty()) kinds.emplace_back("colours");
  return fmt::format("{}", fmt::join(kinds, " and "));
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
  if (pass_numbers("vertex", vertex) > 0) ++vertices_with_more_;
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
  if (pass_numbers("face", face) > 0) ++faces_with_more_;
}

}  // namespace

std::size_t off_keyword_bytes(std::string_view word) {
  constexpr std::string_view kKeyword = "OFF";
  std::size_t at = 0;
  for (const std::string_view prefix : {"ST", "C", "N", "4", "n"})
    if (word.substr(at).starts_with(prefix) && !word.substr(at).starts_with(kKeyword))
      at += prefix.size();
  if (!word.substr(at).starts_with(kKeyword)) return 0;
  const std::size_t end = at + kKeyword.size();
  const bool ends = end == word.size() || (word[end] >= '0' && word[end] <= '9');
  return ends ? end : 0;
}

AttributedMesh read_off(Input& input, Reading& reading) {
  return {OffReader(input, reading).read()};
}

PLAIT_END_NAMESPACE
