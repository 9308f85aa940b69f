// OBJ: the polygons of a Wavefront file, the colours that follow its coordinates, and the texture
// coordinates that its faces name. What else the file has is counted and left out. A keyword that
// the format does not have is an error, so that a damaged line does not go unnoticed. Source:
// Wavefront Technologies, "Advanced Visualizer manual", appendix B1, 1992. Tags (t crease) are
// those of Pixar, "OpenSubdiv", 2012.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "mesh/connectivity.h"
#include "mesh/files/face_divider.h"
#include "mesh/files/obj_texture.h"
#include "mesh/files/readers.h"
#include "mesh/files/text_input.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Statements that are left out. Those of one name are counted together.
struct PassedStatement {
  std::string_view keyword, one, many;
  bool is_of_vertices = false;
};
constexpr std::array kPassed = std::to_array<PassedStatement>({
    {"vn", "normal", "normals", true},
    {"t", "tag (t crease and its like)", "tags (t crease and its like)"},
    {"g", "group", "groups"},
    {"o", "object name", "object names"},
    {"usemtl", "use of a material", "uses of materials"},
    {"mtllib", "material library", "material libraries"},
    {"l", "line element", "line elements"},
    {"p", "point element", "point elements"},
    {"call", "call of another file, which was not read",
     "calls of other files, which were not read"},
    {"csh", "command of a shell, which was not run", "commands of a shell, which were not run"},
});
constexpr std::string_view kOneFreeForm = "statement of curves, surfaces and display",
                           kManyFreeForm = "statements of curves, surfaces and display";
constexpr std::array kFreeForm = std::to_array<std::string_view>(
    {"vp",     "deg",    "bmat",     "step",  "cstype",   "curv",       "curv2",     "surf",
     "parm",   "trim",   "hole",     "scrv",  "sp",       "end",        "con",       "mg",
     "bevel",  "lod",    "c_interp", "ctech", "d_interp", "shadow_obj", "trace_obj", "stech",
     "maplib", "usemap", "res",      "cdc",   "cdp",      "bzp",        "bsp"});
/// ZBrush writes the colours of vertices in comments, a mask and a colour in 8 digits each.
constexpr std::string_view kPaintComment = "#MRGB";
constexpr std::uint64_t kPaintDigits = 8;
/// Smoothing groups say only which normals a viewer shall show.
constexpr std::string_view kSmoothing = "s";

class ObjReader {
 public:
  ObjReader(Input& input, Reading& reading)
      : text_(
            input,
            {.hash_comments = true, .backslash_continues = true, .digits_comment = kPaintComment}),
        reading_(reading) {}

  AttributedMesh read() {
    for (bool more = text_.seek_word(); more; more = text_.next_line()) {
      const std::string_view keyword = text_.word();
      if (keyword == "v")
        read_vertex();
      else if (keyword == "vt")
        read_texture();
      else if (keyword == "f" || keyword == "fo")
        read_face();
      else
        pass_statement(keyword);
    }
    if (highest_ >= mesh_.positions.size() && face_count_ > 0)
      text_.input().refuse_at_line(
          highest_line_, fmt::format("face {}: expected a vertex from 1 to {}, found {}",
                                     highest_face_, mesh_.positions.size(), highest_ + 1));
    divider_.finish(text_.input(), 1, reading_.warnings);
    AttributedMesh result;
    // A colour is kept if all vertices have one.
    if (!colours_.empty() && colours_.size() == 3 * mesh_.positions.size()) {
      coloured_ = 0;
      result.attributes.push_back(attribute_of<float>("color", 3, colours_));
    }
    if (const ObjTexture::Result texture = texture_.finish(mesh_.positions.size());
        !texture.coordinates.empty()) {
      result.attributes.push_back(
          attribute_of<ObjTexture::Coordinates>("texture", 2, texture.coordinates));
      reading_.leave_out_of_vertices("texture coordinates of further corners, at seams,",
                                     texture.seam_vertices);
      textures_ = 0;
    }
    leave_out();
    result.mesh = std::move(mesh_);
    return result;
  }

 private:
  template <class Record>
  static MeshAttribute attribute_of(std::string_view name, std::uint32_t components,
                                    std::span<const Record> records) {
    const std::span<const std::byte> bytes = std::as_bytes(records);
    return {{std::string(name), ComponentType::kFloat32, components}, {bytes.begin(), bytes.end()}};
  }
  void pass_statement(std::string_view keyword);
  void leave_out() const;
  void read_vertex();
  void read_texture();
  void read_face();
  VertexId parse_corner(std::string_view word);
  std::string face_name() const { return fmt::format("face {}", face_count_); }

  TextInput text_;
  Reading& reading_;
  IndexedMesh mesh_;
  FaceDivider divider_{mesh_};
  std::array<std::uint64_t, kPassed.size()> passed_{};
  std::uint64_t free_form_ = 0, weights_ = 0, coloured_ = 0;
  ObjTexture texture_;  ///< if attributes shall be read
  /// Texture coordinates, and their third numbers.
  std::uint64_t textures_ = 0, depths_ = 0;
  std::vector<float> colours_;  ///< of the vertices that have one, if attributes shall be read
  std::uint64_t face_count_ = 0;
  /// The highest vertex that a face names, with the line and the number of that face. Vertices may
  /// follow the faces that name them, so the check comes at the end.
  std::uint64_t highest_ = 0, highest_line_ = 0, highest_face_ = 0;
};

void ObjReader::pass_statement(std::string_view keyword) {
  const auto known = std::ranges::find(kPassed, keyword, &PassedStatement::keyword);
  if (known != kPassed.end())
    ++passed_[static_cast<std::size_t>(known - kPassed.begin())];
  else if (std::ranges::find(kFreeForm, keyword) != kFreeForm.end())
    ++free_form_;
  else if (keyword != kSmoothing)
    text_.refuse("statement", "an OBJ keyword", keyword);
}

void ObjReader::leave_out() const {
  reading_.leave_out_of_vertices("colours", coloured_);
  reading_.leave_out_of_vertices("colours and masks in comments (#MRGB)",
                                 text_.hexadecimal_digits() / kPaintDigits);
  reading_.leave_out_of_vertices("weights", weights_);
  reading_.leave_out(textures_,
                     reading_.attributes ? "texture coordinate, because some corners have none"
                                         : "texture coordinate",
                     reading_.attributes ? "texture coordinates, because some corners have none"
                                         : "texture coordinates");
  reading_.leaves_out_of_vertices = reading_.leaves_out_of_vertices || textures_ > 0;
  reading_.leave_out(depths_, "third texture coordinate", "third texture coordinates");
  for (std::size_t at = 0; at < kPassed.size(); ++at) {
    reading_.leave_out(passed_[at], kPassed[at].one, kPassed[at].many);
    if (kPassed[at].is_of_vertices && passed_[at] > 0) reading_.leaves_out_of_vertices = true;
  }
  reading_.leave_out(free_form_, kOneFreeForm, kManyFreeForm);
}

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
  std::size_t more = 0;
  std::array<float, 3> colour{};
  bool is_one = true;
  for (std::string_view word = text_.word(); !word.empty(); word = text_.word(), ++more) {
    const std::optional<double> number = parse_number(word);
    if (!number) refuse("a number", word);
    is_one = is_one && *number == 1;
    if (more < colour.size()) colour[more] = static_cast<float>(*number);
  }
  if (more > 1) ++coloured_;
  if (more == colour.size() && reading_.attributes)
    colours_.insert(colours_.end(), colour.begin(), colour.end());
  if (more == 1 && !is_one) ++weights_;
  if (mesh_.positions.size() >= kMaxVertices) refuse("at most 2^32 - 2 vertices", "more");
  mesh_.positions.push_back(p);
}

void ObjReader::read_texture() {
  ++textures_;
  if (!reading_.attributes) return;
  std::array<float, 3> numbers{};  // one that is not there is 0
  std::size_t count = 0;
  for (std::string_view word = text_.word(); !word.empty(); word = text_.word(), ++count) {
    const std::optional<double> number = parse_number(word);
    if (!number || count == numbers.size())
      text_.refuse(fmt::format("texture coordinate {}", textures_), "one to three numbers", word);
    numbers[count] = static_cast<float>(*number);
  }
  if (numbers[2] != 0) ++depths_;
  texture_.add_coordinates({numbers[0], numbers[1]});
}

/// "7", "-1", "7/1", "7//3" or "7/1/3": a vertex, texture coordinates and a normal, which does not
/// count.
VertexId ObjReader::parse_corner(std::string_view word) {
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
  const auto vertex = static_cast<VertexId>(*number < 0 ? count + *number : *number - 1);
  if (reading_.attributes) {
    const std::string_view texture = rest.substr(std::min<std::size_t>(1, rest.size()));
    texture_.add_corner(vertex, parse_integer(texture.substr(0, texture.find('/'))).value_or(0),
                        mesh_.positions.size());
  }
  return vertex;
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

AttributedMesh read_obj(Input& input, Reading& reading) { return ObjReader(input, reading).read(); }

PLAIT_END_NAMESPACE
