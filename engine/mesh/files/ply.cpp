// PLY: vertices and faces with any properties. Binary records of fixed size are read in bulk,
// everything else value by value.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <type_traits>
#include <utility>

#include "io/huge_pages.h"
#include "mesh/connectivity.h"
#include "mesh/files/face_divider.h"
#include "mesh/files/ply_records.h"
#include "mesh/narrowing.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A list that claims more entries than this is an error: vertex indices have 32 bits.
constexpr double kMaxListCount = 4294967295.0;

/// The positions of x, y and z among the properties of a vertex.
struct VertexProperties {
  std::array<std::size_t, 3> index;
};

bool is_vertex_list(const PlyProperty& property) {
  return property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <class Values>
std::uint64_t read_list_count(Values& values, const PlyProperty& property) {
  const double count = values.value(property.count_type);
  if (!(count >= 0 && count <= kMaxListCount) || count != std::floor(count))
    values.refuse(fmt::format("a count for the list {}", in_quotes(property.name)),
                  fmt::format("{}", count));
  return static_cast<std::uint64_t>(count);
}

template <class Values>
void skip_property(Values& values, const PlyProperty& property) {
  values.skip(property.type, property.is_list ? read_list_count(values, property) : 1);
}

class PlyReader {
 public:
  PlyReader(Input& input, PlyHeader header, Reading& reading)
      : input_(input), header_(std::move(header)), reading_(reading) {
    check_header();
    if (reading_.attributes)
      of_vertices_ = PlyRecords(*vertices_, attributes_of(*vertices_, no_attributes_));
    if (reading_.face_attributes) {
      of_faces_ = PlyRecords(*faces_, face_attributes_of(*faces_, no_face_attributes_));
      std::erase(no_face_attributes_, faces_->properties[face_list_].name);
    }
  }

  void read() {
    if (header_.format == PlyFormat::kAscii)
      read_body(TextPlyValues(input_, header_));
    else
      read_body(BinaryPlyValues(input_, header_));
  }

  IndexedMesh finish() {
    divider_.finish(input_, 0, reading_.warnings);
    if (reading_.sink != nullptr) reading_.sink->take(std::exchange(mesh_, {}));
    if (ignored_bytes_ > 0)
      reading_.warn(fmt::format("{}: {} bytes after the last element of the header were ignored",
                                input_.path().native(), ignored_bytes_));
    leave_out();
    of_vertices_.say_lost_digits(input_, reading_);
    of_faces_.say_lost_digits(input_, reading_);
    return std::move(mesh_);
  }
  std::optional<ComponentType> precision() const;
  std::vector<MeshAttribute> finish_attributes() { return of_vertices_.finish(); }
  std::vector<MeshAttribute> finish_face_attributes() { return of_faces_.finish(); }

 private:
  template <class Values>
  void read_body(Values values) {
    if (reading_.sink != nullptr) reading_.sink->begin(vertices_->count, faces_->count);
    for (const PlyElement& element : header_.elements) {
      // Elements without properties take no bytes, whatever their count.
      if (element.properties.empty()) continue;
      if (&element == vertices_) {
        const std::uint64_t count = input_.plausible_count(element.count, element.least_bytes());
        if (reading_.sink == nullptr) reserve_huge(mesh_.positions, count);
        of_vertices_.reserve(count);
        read_vertices(values);
      } else if (&element == faces_) {
        const std::uint64_t count = input_.plausible_count(element.count, least_triangle_bytes());
        if (reading_.sink == nullptr) reserve_huge(mesh_.faces, count);
        of_faces_.reserve(count);
        read_faces(values);
      } else {
        skip_element(values, element);
      }
    }
    if (!values.at_end()) ignore_rest();
  }

  /// Reads to the end of the input, so that the checksum of a compressed file is checked.
  void ignore_rest() {
    do {
      ignored_bytes_ += input_.unread().size();
      input_.consume(input_.unread().size());
    } while (input_.fill());
  }

  void give_part() {
    if (reading_.sink == nullptr ||
        std::max(mesh_.positions.size(), mesh_.faces.size()) < MeshSink::kPart)
      return;
    reading_.sink->take(mesh_);
    mesh_.positions.clear();
    mesh_.faces.clear();
  }

  void check_header();
  void leave_out() const;
  std::uint64_t least_triangle_bytes() const;
  [[noreturn]] void refuse_header(std::string_view what) const {
    input_.refuse_at_line(header_.lines, fmt::format("header: {}", what));
  }

  template <class Values>
  void skip_element(Values& values, const PlyElement& element);
  template <class Values>
  void read_vertices(Values& values);
  template <class Values>
  void read_faces(Values& values);
  template <class Values>
  void read_face(Values& values);
  template <class Values>
  [[noreturn]] void refuse_polygon(const Values& values, std::uint64_t corners) const;
  std::uint64_t read_vertices_in_bulk(BinaryPlyValues& values);
  /// Where the list of a triangle is in its bytes, and how many bytes the triangle has.
  struct TriangleBytes {
    std::size_t list, all;
  };
  bool read_triangle_in_bulk(BinaryPlyValues& values, const TriangleBytes& place);
  bool is_vertex(double index) const {
    return index >= 0 && index < static_cast<double>(vertices_->count) &&
           index == std::floor(index);
  }

  Input& input_;
  PlyHeader header_;
  Reading& reading_;
  const PlyElement* vertices_ = nullptr;
  const PlyElement* faces_ = nullptr;
  VertexProperties position_{};
  std::size_t face_list_ = 0;
  std::uint64_t ignored_bytes_ = 0;
  PlyRecords of_vertices_, of_faces_;
  /// Properties that cannot be attributes.
  std::vector<std::string> no_attributes_, no_face_attributes_;
  IndexedMesh mesh_;
  FaceDivider divider_{mesh_};
};

std::optional<ComponentType> PlyReader::precision() const {
  const auto has = [&](std::initializer_list<ComponentType> types) {
    return std::ranges::any_of(position_.index, [&](std::size_t property) {
      return std::ranges::find(types, vertices_->properties[property].type) != types.end();
    });
  };
  const auto fits = [](double number) { return as_float32(number) == number; };
  if (has({ComponentType::kFloat64})) return ComponentType::kFloat64;
  // Text may have more digits than the type that the header names.
  if (has({ComponentType::kFloat32}) && header_.format == PlyFormat::kAscii) return std::nullopt;
  if (has({ComponentType::kInt32, ComponentType::kUint32}) &&
      !std::ranges::all_of(mesh_.positions, [&](const Vector3<double>& p) {
        return fits(p.x) && fits(p.y) && fits(p.z);
      }))
    return ComponentType::kFloat64;
  return ComponentType::kFloat32;
}

void PlyReader::leave_out() const {
  const auto names_of = [](const PlyElement& element, auto&& is_left_out) {
    std::vector<std::string> names;
    for (std::size_t at = 0; at < element.properties.size(); ++at)
      if (is_left_out(at)) names.push_back(element.properties[at].name);
    return names;
  };
  const auto say_of_vertices = [&](std::string_view of, const std::vector<std::string>& names) {
    if (!names.empty())
      reading_.leave_out_of_vertices(fmt::format("{} {}", of, fmt::join(names, ", ")),
                                     vertices_->count);
  };
  if (reading_.attributes)
    say_of_vertices("lists, second ones of a name, and names that no attribute can have:",
                    no_attributes_);
  else
    say_of_vertices("properties", names_of(*vertices_, [&](std::size_t at) {
                      return std::ranges::find(position_.index, at) == position_.index.end();
                    }));
  const std::vector<std::string> names =
      reading_.face_attributes
          ? no_face_attributes_
          : names_of(*faces_, [&](std::size_t at) { return at != face_list_; });
  if (!names.empty())
    reading_.leave_out_of(fmt::format("properties {}", fmt::join(names, ", ")), faces_->count,
                          "face", "faces");
  for (const PlyElement& element : header_.elements)
    if (&element != vertices_ && &element != faces_)
      reading_.leave_out(element.count, fmt::format("element {}", element.name),
                         fmt::format("elements {}", element.name));
  for (const std::string& file : header_.texture_files)
    reading_.left_out.push_back(fmt::format("texture file {}", file));
}

void PlyReader::check_header() {
  for (const PlyElement& element : header_.elements) {
    if (element.name == "vertex") vertices_ = &element;
    if (element.name == "face") faces_ = &element;
  }
  if (vertices_ == nullptr) refuse_header("expected an element vertex, found none");
  if (faces_ == nullptr) refuse_header("expected an element face, found none");
  if (vertices_->count > kMaxVertices)
    refuse_header(
        fmt::format("expected at most {} vertices, found {}", kMaxVertices, vertices_->count));
  if (faces_->count > kMaxFaces)
    refuse_header(fmt::format("expected at most {} faces, found {}", kMaxFaces, faces_->count));

  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string_view name = std::string_view("xyz").substr(axis, 1);
    std::size_t found = 0;
    for (std::size_t i = 0; i < vertices_->properties.size(); ++i)
      if (vertices_->properties[i].name == name && !vertices_->properties[i].is_list) {
        position_.index[axis] = i;
        ++found;
      }
    if (found != 1)
      refuse_header(fmt::format("expected one vertex property {}, found {}", name, found));
  }
  std::size_t lists = 0;
  for (std::size_t i = 0; i < faces_->properties.size(); ++i)
    if (is_vertex_list(faces_->properties[i])) {
      face_list_ = i;
      ++lists;
    }
  if (lists != 1)
    refuse_header(
        fmt::format("expected one face list vertex_indices or vertex_index, found {}", lists));
}

std::uint64_t PlyReader::least_triangle_bytes() const {
  const std::size_t index_bytes = component_bytes(faces_->properties[face_list_].type);
  // In ascii, a number and its blank take at least two bytes, and a face has at least four numbers.
  return header_.format == PlyFormat::kAscii ? 8 : faces_->least_bytes() + 3 * index_bytes;
}

template <class Values>
void PlyReader::skip_element(Values& values, const PlyElement& element) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    values.begin_element({element.name, i, element.count});
    for (const PlyProperty& property : element.properties) skip_property(values, property);
    values.end_element();
  }
}

/// REQUIRES: no lists, a record shorter than the buffer. Returns the number of records, all of
/// which it has read.
std::uint64_t PlyReader::read_vertices_in_bulk(BinaryPlyValues& values) {
  std::array<std::size_t, 3> offset{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < position_.index[axis]; ++i)
      offset[axis] += component_bytes(vertices_->properties[i].type);
  const auto type = [&](std::size_t axis) {
    return vertices_->properties[position_.index[axis]].type;
  };
  const std::array<ComponentType, 3> types = {type(0), type(1), type(2)};
  const std::size_t stride = vertices_->least_bytes();
  const bool big_endian = values.big_endian();

  std::uint64_t done = 0;
  while (done < vertices_->count) {
    values.begin_element({"vertex", done, vertices_->count});
    if (!input_.ensure(stride)) values.refuse_end();
    const std::string_view bytes = input_.unread();
    const std::uint64_t ready =
        std::min<std::uint64_t>(bytes.size() / stride, vertices_->count - done);
    for (std::uint64_t i = 0; i < ready; ++i) {
      const char* record = bytes.data() + i * stride;
      const Vector3<double> p = {load_ply_number(types[0], record + offset[0], big_endian),
                                 load_ply_number(types[1], record + offset[1], big_endian),
                                 load_ply_number(types[2], record + offset[2], big_endian)};
      if (!input_.takes(p.x) || !input_.takes(p.y) || !input_.takes(p.z)) {
        values.begin_element({"vertex", done + i, vertices_->count});
        values.refuse_at(input_.offset() + i * stride, "a finite position",
                         fmt::format("({}, {}, {})", p.x, p.y, p.z));
      }
      mesh_.positions.push_back(p);
      of_vertices_.append_bytes(record, big_endian);
    }
    input_.consume(ready * stride);
    done += ready;
    give_part();
  }
  return done;
}

template <class Values>
void PlyReader::read_vertices(Values& values) {
  std::uint64_t first = 0;
  if constexpr (std::is_same_v<Values, BinaryPlyValues>)
    if (!vertices_->has_lists() && vertices_->least_bytes() <= Input::kBufferBytes / 4)
      first = read_vertices_in_bulk(values);
  for (std::uint64_t vertex = first; vertex < vertices_->count; ++vertex) {
    values.begin_element({"vertex", vertex, vertices_->count});
    Vector3<double> p{};
    for (std::size_t i = 0; i < vertices_->properties.size(); ++i) {
      const auto axis = std::find(position_.index.begin(), position_.index.end(), i);
      if (axis == position_.index.end()) {
        if (vertices_->properties[i].is_list || of_vertices_.is_empty())
          skip_property(values, vertices_->properties[i]);
        else
          of_vertices_.read(values, i);
        continue;
      }
      const double value = values.value(vertices_->properties[i].type);
      if (!input_.takes(value)) values.refuse("a finite position", fmt::format("{}", value));
      p[static_cast<int>(axis - position_.index.begin())] = value;
    }
    of_vertices_.append(values);
    values.end_element();
    mesh_.positions.push_back(p);
    give_part();
  }
}

/// Reads the next face if it is a triangle, has no other list, and lies in the buffer as a whole;
/// otherwise consumes nothing and returns false. A face with a bad index also returns false: the
/// value-by-value reader then reports the place of the index.
bool PlyReader::read_triangle_in_bulk(BinaryPlyValues& values, const TriangleBytes& place) {
  const PlyProperty& list = faces_->properties[face_list_];
  const std::size_t index_bytes = component_bytes(list.type);
  const std::string_view bytes = input_.unread();
  if (bytes.size() < place.all) return false;

  const char* at = bytes.data() + place.list;
  if (load_ply_number(list.count_type, at, values.big_endian()) != 3) return false;
  at += component_bytes(list.count_type);
  std::array<VertexId, 3> face;
  for (VertexId& vertex : face) {
    const double index = load_ply_number(list.type, at, values.big_endian());
    if (!is_vertex(index)) return false;
    vertex = static_cast<VertexId>(index);
    at += index_bytes;
  }
  // With this many triangles, the value-by-value reader reports the error.
  if (mesh_.faces.size() >= kMaxFaces) return false;
  divider_.add_triangle(face);
  of_faces_.append_bytes(bytes.data(), values.big_endian());
  input_.consume(place.all);
  return true;
}

/// Dividing a polygon needs the positions of its corners, which may be anywhere.
template <class Values>
void PlyReader::refuse_polygon(const Values& values, std::uint64_t corners) const {
  try {
    values.refuse("a triangle, because only these are read in parts",
                  fmt::format("{} corners", corners));
  } catch (const Error& error) {
    throw Error(ErrorCode::kNotSupported, error.what()).about(input_.path());
  }
}

template <class Values>
void PlyReader::read_face(Values& values) {
  const std::size_t triangles = mesh_.faces.size();
  for (std::size_t i = 0; i < faces_->properties.size(); ++i) {
    const PlyProperty& property = faces_->properties[i];
    if (i != face_list_) {
      if (property.is_list || of_faces_.is_empty())
        skip_property(values, property);
      else
        of_faces_.read(values, i);
      continue;
    }
    const std::uint64_t corners = read_list_count(values, property);
    if (corners < 3) values.refuse("three corners or more", fmt::format("{}", corners));
    if (corners > 3 && reading_.sink != nullptr) refuse_polygon(values, corners);
    divider_.begin();
    for (std::uint64_t corner = 0; corner < corners; ++corner) {
      const double index = values.value(property.type);
      if (!is_vertex(index))
        values.refuse(fmt::format("a vertex below {}", vertices_->count), fmt::format("{}", index));
      if (!divider_.add(static_cast<VertexId>(index)))
        values.refuse(fmt::format("at most {} triangles", kMaxFaces), "more");
    }
  }
  for (std::size_t added = triangles; added < mesh_.faces.size(); ++added) of_faces_.append(values);
}

template <class Values>
void PlyReader::read_faces(Values& values) {
  bool bulk = false;
  TriangleBytes place{};
  if constexpr (std::is_same_v<Values, BinaryPlyValues>) {
    std::size_t lists = 0;
    for (const PlyProperty& property : faces_->properties) lists += property.is_list ? 1 : 0;
    bulk = lists == 1;
    for (std::size_t i = 0; i < face_list_; ++i)
      place.list += component_bytes(faces_->properties[i].type);
    place.all = faces_->least_bytes() + 3 * component_bytes(faces_->properties[face_list_].type);
  }
  for (std::uint64_t face = 0; face < faces_->count; ++face) {
    give_part();
    if constexpr (std::is_same_v<Values, BinaryPlyValues>)
      if (bulk && read_triangle_in_bulk(values, place)) continue;
    values.begin_element({"face", face, faces_->count});
    read_face(values);
    values.end_element();
  }
}

}  // namespace

AttributedMesh read_ply(Input& input, Reading& reading) {
  PlyReader reader(input, read_ply_header(input), reading);
  reader.read();
  const std::optional<ComponentType> precision = reader.precision();
  AttributedMesh result{reader.finish(), precision};
  result.attributes = reader.finish_attributes();
  result.face_attributes = reader.finish_face_attributes();
  return result;
}

PLAIT_END_NAMESPACE
