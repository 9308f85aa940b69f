// PLY: vertices and faces with any properties. Binary records of fixed size are read in bulk,
// everything else value by value.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

#include "io/huge_pages.h"
#include "mesh/connectivity.h"
#include "mesh/files/face_divider.h"
#include "mesh/files/lost_digits.h"
#include "mesh/files/ply_attributes.h"
#include "mesh/files/ply_values.h"
#include "mesh/files/readers.h"
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

/// Returns false if the type has no such number.
bool append_number(PlyType type, double value, std::vector<std::byte>& to) {
  const auto append = [&]<class Number>(Number number) {
    const bool fits = value >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
                      value <= static_cast<double>(std::numeric_limits<Number>::max());
    if (std::is_integral_v<Number> ? !fits || value != std::floor(value)
                                   : !fits && std::isfinite(value))
      return false;
    number = static_cast<Number>(value);
    const auto bytes = std::as_bytes(std::span(&number, 1));
    to.insert(to.end(), bytes.begin(), bytes.end());
    return true;
  };
  switch (type) {
    case PlyType::kInt8:
      return append(std::int8_t{});
    case PlyType::kUint8:
      return append(std::uint8_t{});
    case PlyType::kInt16:
      return append(std::int16_t{});
    case PlyType::kUint16:
      return append(std::uint16_t{});
    case PlyType::kInt32:
      return append(std::int32_t{});
    case PlyType::kUint32:
      return append(std::uint32_t{});
    case PlyType::kFloat32:
      return append(float{});
    case PlyType::kFloat64:
      break;
  }
  return append(double{});
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
    if (reading_.attributes) {
      attributes_ = attributes_of(*vertices_, no_attributes_);
      records_.resize(attributes_.size());
      lost_digits_.resize(vertices_->properties.size());
    }
    if (reading_.face_attributes) {
      face_attributes_ = face_attributes_of(*faces_, no_face_attributes_);
      face_records_.resize(face_attributes_.size());
      lost_digits_of_faces_.resize(faces_->properties.size());
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
    say_lost_digits(*vertices_, lost_digits_);
    say_lost_digits(*faces_, lost_digits_of_faces_);
    return std::move(mesh_);
  }
  std::optional<ComponentType> precision() const;
  std::vector<MeshAttribute> finish_attributes() { return finish(attributes_, records_); }
  std::vector<MeshAttribute> finish_face_attributes() {
    return finish(face_attributes_, face_records_);
  }

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
        for (std::size_t at = 0; at < attributes_.size(); ++at)
          reserve_huge(records_[at], count * attributes_[at].schema.record_bytes());
        read_vertices(values);
      } else if (&element == faces_) {
        if (reading_.sink == nullptr)
          reserve_huge(mesh_.faces, input_.plausible_count(element.count, least_triangle_bytes()));
        for (std::size_t at = 0; at < face_attributes_.size(); ++at)
          reserve_huge(face_records_[at],
                       input_.plausible_count(element.count, least_triangle_bytes()) *
                           face_attributes_[at].schema.record_bytes());
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

  /// A number of an element's record in the file, and the records that get it.
  struct RecordPart {
    std::size_t offset, bytes;
    std::vector<std::byte>* to;

    void append(const char* record, bool big_endian) const {
      for (std::size_t byte = 0; byte < bytes; ++byte)
        to->push_back(
            static_cast<std::byte>(record[offset + (big_endian ? bytes - 1 - byte : byte)]));
    }
  };
  std::vector<RecordPart> record_parts();
  std::vector<RecordPart> face_record_parts();

  void give_part() {
    if (reading_.sink == nullptr ||
        std::max(mesh_.positions.size(), mesh_.faces.size()) < MeshSink::kPart)
      return;
    reading_.sink->take(mesh_);
    mesh_.positions.clear();
    mesh_.faces.clear();
  }

  static std::vector<MeshAttribute> finish(const std::vector<PlyAttribute>& attributes,
                                           std::vector<std::vector<std::byte>>& records) {
    std::vector<MeshAttribute> result;
    for (std::size_t at = 0; at < attributes.size(); ++at)
      result.push_back({attributes[at].schema, std::move(records[at])});
    return result;
  }

  void check_header();
  void leave_out() const;
  void say_lost_digits(const PlyElement& element, std::span<const LostDigits> lost) const;
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
  template <class Values>
  void add_numbers(Values& values, const PlyElement& element,
                   std::span<const PlyAttribute> attributes, std::span<const double> numbers,
                   std::vector<std::vector<std::byte>>& records);
  bool read_triangle_in_bulk(BinaryPlyValues& values, std::span<const RecordPart> parts);
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
  std::vector<PlyAttribute> attributes_;
  std::vector<std::vector<std::byte>> records_;  ///< [attribute]
  std::vector<LostDigits> lost_digits_;          ///< [property of a vertex]
  std::vector<std::string> no_attributes_;       ///< vertex properties that cannot be attributes
  std::vector<PlyAttribute> face_attributes_;
  std::vector<std::vector<std::byte>> face_records_;  ///< [face attribute]
  std::vector<LostDigits> lost_digits_of_faces_;      ///< [property of a face]
  std::vector<std::string> no_face_attributes_;
  std::vector<double> face_numbers_;  ///< [property] of the present face
  IndexedMesh mesh_;
  FaceDivider divider_{mesh_};
};

std::optional<ComponentType> PlyReader::precision() const {
  const auto has = [&](std::initializer_list<PlyType> types) {
    return std::ranges::any_of(position_.index, [&](std::size_t property) {
      return std::ranges::find(types, vertices_->properties[property].type) != types.end();
    });
  };
  const auto fits = [](double number) { return as_float32(number) == number; };
  if (has({PlyType::kFloat64})) return ComponentType::kFloat64;
  // Text may have more digits than the type that the header names.
  if (has({PlyType::kFloat32}) && header_.format == PlyFormat::kAscii) return std::nullopt;
  if (has({PlyType::kInt32, PlyType::kUint32}) &&
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

void PlyReader::say_lost_digits(const PlyElement& element, std::span<const LostDigits> lost) const {
  for (std::size_t property = 0; property < lost.size(); ++property)
    if (lost[property].count() > 0)
      reading_.warn(fmt::format("{}: {} property {}: {}", input_.path().native(), element.name,
                                in_quotes(element.properties[property].name),
                                lost[property].text()));
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
  const std::size_t index_bytes = ply_type_bytes(faces_->properties[face_list_].type);
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

std::vector<PlyReader::RecordPart> PlyReader::record_parts() {
  std::vector<RecordPart> parts;
  for (std::size_t at = 0; at < attributes_.size(); ++at)
    for (const std::size_t property : attributes_[at].properties) {
      std::size_t offset = 0;
      for (std::size_t i = 0; i < property; ++i)
        offset += ply_type_bytes(vertices_->properties[i].type);
      parts.push_back(
          {offset, ply_type_bytes(vertices_->properties[property].type), &records_[at]});
    }
  return parts;
}

/// Of triangles. REQUIRES: no other list.
std::vector<PlyReader::RecordPart> PlyReader::face_record_parts() {
  std::vector<RecordPart> parts;
  for (std::size_t at = 0; at < face_attributes_.size(); ++at) {
    const std::size_t property = face_attributes_[at].properties[0];
    std::size_t offset = 0;
    for (std::size_t i = 0; i < property; ++i) {
      const PlyProperty& before = faces_->properties[i];
      offset += before.is_list ? ply_type_bytes(before.count_type) + 3 * ply_type_bytes(before.type)
                               : ply_type_bytes(before.type);
    }
    parts.push_back(
        {offset, ply_type_bytes(faces_->properties[property].type), &face_records_[at]});
  }
  return parts;
}

/// REQUIRES: no lists, a record shorter than the buffer. Returns the number of records, all of
/// which it has read.
std::uint64_t PlyReader::read_vertices_in_bulk(BinaryPlyValues& values) {
  std::array<std::size_t, 3> offset{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < position_.index[axis]; ++i)
      offset[axis] += ply_type_bytes(vertices_->properties[i].type);
  const auto type = [&](std::size_t axis) {
    return vertices_->properties[position_.index[axis]].type;
  };
  const std::array<PlyType, 3> types = {type(0), type(1), type(2)};
  const std::size_t stride = vertices_->least_bytes();
  const bool big_endian = values.big_endian();
  const std::vector<RecordPart> parts = record_parts();

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
      for (const RecordPart& part : parts) part.append(record, big_endian);
    }
    input_.consume(ready * stride);
    done += ready;
    give_part();
  }
  return done;
}

/// Appends the numbers of an element to the records of its attributes. [property of the element]
template <class Values>
void PlyReader::add_numbers(Values& values, const PlyElement& element,
                            std::span<const PlyAttribute> attributes,
                            std::span<const double> numbers,
                            std::vector<std::vector<std::byte>>& records) {
  for (std::size_t at = 0; at < attributes.size(); ++at)
    for (const std::size_t property : attributes[at].properties)
      if (!append_number(element.properties[property].type, numbers[property], records[at]))
        values.refuse(
            fmt::format("a number of the type of {}", in_quotes(element.properties[property].name)),
            fmt::format("{}", numbers[property]));
}

template <class Values>
void PlyReader::read_vertices(Values& values) {
  std::uint64_t first = 0;
  if constexpr (std::is_same_v<Values, BinaryPlyValues>)
    if (!vertices_->has_lists() && vertices_->least_bytes() <= Input::kBufferBytes / 4)
      first = read_vertices_in_bulk(values);
  std::vector<double> numbers(vertices_->properties.size());
  for (std::uint64_t vertex = first; vertex < vertices_->count; ++vertex) {
    values.begin_element({"vertex", vertex, vertices_->count});
    Vector3<double> p{};
    for (std::size_t i = 0; i < vertices_->properties.size(); ++i) {
      const auto axis = std::find(position_.index.begin(), position_.index.end(), i);
      if (axis == position_.index.end()) {
        if (vertices_->properties[i].is_list || attributes_.empty())
          skip_property(values, vertices_->properties[i]);
        else
          numbers[i] = values.value(vertices_->properties[i].type);
        if constexpr (std::is_same_v<Values, TextPlyValues>)
          if (vertices_->properties[i].type == PlyType::kFloat32 && !attributes_.empty() &&
              !vertices_->properties[i].is_list)
            lost_digits_[i].add(values.word(), numbers[i]);
        continue;
      }
      const double value = values.value(vertices_->properties[i].type);
      if (!input_.takes(value)) values.refuse("a finite position", fmt::format("{}", value));
      p[static_cast<int>(axis - position_.index.begin())] = value;
    }
    add_numbers(values, *vertices_, attributes_, numbers, records_);
    values.end_element();
    mesh_.positions.push_back(p);
    give_part();
  }
}

/// Reads the next face if it is a triangle, has no other list, and lies in the buffer as a whole;
/// otherwise consumes nothing and returns false. A face with a bad index also returns false: the
/// value-by-value reader then reports the place of the index.
bool PlyReader::read_triangle_in_bulk(BinaryPlyValues& values, std::span<const RecordPart> parts) {
  const PlyProperty& list = faces_->properties[face_list_];
  const std::size_t index_bytes = ply_type_bytes(list.type);
  const std::size_t count_bytes = ply_type_bytes(list.count_type);
  const std::uint64_t record_bytes = faces_->least_bytes() + 3 * index_bytes;
  const std::string_view bytes = input_.unread();
  if (bytes.size() < record_bytes) return false;

  const char* at = bytes.data();
  for (std::size_t i = 0; i < face_list_; ++i) at += ply_type_bytes(faces_->properties[i].type);
  if (load_ply_number(list.count_type, at, values.big_endian()) != 3) return false;
  at += count_bytes;
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
  for (const RecordPart& part : parts) part.append(bytes.data(), values.big_endian());
  input_.consume(record_bytes);
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
  face_numbers_.resize(faces_->properties.size());
  for (std::size_t i = 0; i < faces_->properties.size(); ++i) {
    const PlyProperty& property = faces_->properties[i];
    if (i != face_list_) {
      if (property.is_list || face_attributes_.empty()) {
        skip_property(values, property);
        continue;
      }
      face_numbers_[i] = values.value(property.type);
      if constexpr (std::is_same_v<Values, TextPlyValues>)
        if (property.type == PlyType::kFloat32)
          lost_digits_of_faces_[i].add(values.word(), face_numbers_[i]);
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
  if (!face_attributes_.empty())
    for (std::size_t added = triangles; added < mesh_.faces.size(); ++added)
      add_numbers(values, *faces_, face_attributes_, face_numbers_, face_records_);
}

template <class Values>
void PlyReader::read_faces(Values& values) {
  bool bulk = false;
  if constexpr (std::is_same_v<Values, BinaryPlyValues>) {
    std::size_t lists = 0;
    for (const PlyProperty& property : faces_->properties) lists += property.is_list ? 1 : 0;
    bulk = lists == 1;
  }
  const std::vector<RecordPart> parts = bulk ? face_record_parts() : std::vector<RecordPart>{};
  for (std::uint64_t face = 0; face < faces_->count; ++face) {
    give_part();
    if constexpr (std::is_same_v<Values, BinaryPlyValues>)
      if (bulk && read_triangle_in_bulk(values, parts)) continue;
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
