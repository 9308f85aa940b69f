// OBJ: the polygons of a Wavefront file. Normals, texture coordinates, groups, materials, lines,
// points and free-form surfaces are skipped. A keyword that the format does not have is an error,
// so that a damaged line does not go unnoticed.
// Source: Wavefront Technologies, "Advanced Visualizer manual", appendix B1, 1992.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "mesh/connectivity.h"
#include "mesh/files/readers.h"
#include "mesh/files/text_input.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::array kPassedKeywords = std::to_array<std::string_view>(
    {"vt",     "vn",         "vp",        "deg",      "bmat",  "step",     "cstype",
     "p",      "l",          "curv",      "curv2",    "surf",  "parm",     "trim",
     "hole",   "scrv",       "sp",        "end",      "con",   "g",        "s",
     "mg",     "o",          "bevel",     "c_interp", "lod",   "d_interp", "usemtl",
     "mtllib", "shadow_obj", "trace_obj", "ctech",    "stech", "maplib",   "usemap",
     "call",   "csh",        "res",       "cdc",      "cdp",   "bzp",      "bsp"});

class ObjReader {
 public:
  explicit ObjReader(Input& input)
      : text_(input, {.hash_comments = true, .backslash_continues = true}) {}

  IndexedMesh read(Warnings* warnings) {
    for (bool more = text_.seek_word(); more; more = text_.next_line()) {
      const std::string_view keyword = text_.word();
      if (keyword == "v")
        read_vertex();
      else if (keyword == "f" || keyword == "fo")
        read_face();
      else if (std::find(kPassedKeywords.begin(), kPassedKeywords.end(), keyword) ==
               kPassedKeywords.end())
        text_.refuse("statement", "an OBJ keyword", keyword);
    }
    if (highest_ >= mesh_.positions.size() && face_count_ > 0)
      text_.input().refuse_at_line(
          highest_line_, fmt::format("face {}: expected a vertex from 1 to {}, found {}",
                                     highest_face_, mesh_.positions.size(), highest_ + 1));
    divider_.report(text_.input(), warnings);
    return std::move(mesh_);
  }

 private:
  void read_vertex();
  void read_face();
  VertexId parse_corner(std::string_view word) const;
  std::string face_name() const { return fmt::format("face {}", face_count_); }

  TextInput text_;
  IndexedMesh mesh_;
  FaceDivider divider_{mesh_.faces};
  std::uint64_t face_count_ = 0;
  /// The highest vertex that a face names, with the line and the number of that face. Vertices may
  /// follow the faces that name them, so the check comes at the end.
  std::uint64_t highest_ = 0, highest_line_ = 0, highest_face_ = 0;
};

void ObjReader::read_vertex() {
  const auto refuse = [&](std::string_view expected, std::string_view found) {
    text_.refuse(fmt::format("vertex {}", mesh_.positions.size() + 1), expected, found);
  };
  Vector3<double> p{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = text_.word();
    const std::optional<double> number = parse_number(word);
    if (!number || !text_.input().takes(*number)) refuse("a finite number", word);
    p[axis] = *number;
  }
  // More numbers may follow: a weight, or a colour that some programs write here.
  for (std::string_view word = text_.word(); !word.empty(); word = text_.word())
    if (!parse_number(word)) refuse("a number", word);
  if (mesh_.positions.size() >= kMaxVertices) refuse("at most 2^32 - 2 vertices", "more");
  mesh_.positions.push_back(p);
}

/// "7", "-1", "7/1", "7//3" or "7/1/3"; only the part before the first slash counts.
VertexId ObjReader::parse_corner(std::string_view word) const {
  const std::size_t slash = std::min(word.find('/'), word.size());
  const std::optional<std::int64_t> number = parse_integer(word.substr(0, slash));
  const std::string_view rest = word.substr(slash);
  if (!number || *number == 0 || rest.find_first_not_of("/-0123456789") != std::string_view::npos ||
      std::count(rest.begin(), rest.end(), '/') > 2)
    text_.refuse(face_name(), "a vertex as 7, -1, 7/1, 7//3 or 7/1/3", word);
  const auto count = static_cast<std::int64_t>(mesh_.positions.size());
  if (*number < -count)
    text_.refuse(face_name(), fmt::format("at most {} vertices back", count), word);
  if (*number > static_cast<std::int64_t>(kMaxVertices))
    text_.refuse(face_name(), fmt::format("a vertex of at most {}", kMaxVertices), word);
  return static_cast<VertexId>(*number < 0 ? count + *number : *number - 1);
}

void ObjReader::read_face() {
  ++face_count_;
  divider_.begin();
  for (std::string_view word = text_.word(); !word.empty(); word = text_.word()) {
    const VertexId vertex = parse_corner(word);
    if (vertex > highest_ || highest_face_ == 0) {
      highest_ = vertex;
      highest_line_ = text_.line();
      highest_face_ = face_count_;
    }
    if (!divider_.add(vertex)) text_.refuse(face_name(), "at most 2^30 triangles", "more");
  }
  if (divider_.corners() < 3) text_.refuse(face_name(), "three corners or more", "");
}

}  // namespace

IndexedMesh read_obj(Input& input, Warnings* warnings) { return ObjReader(input).read(warnings); }

PLAIT_END_NAMESPACE
