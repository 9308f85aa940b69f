#include "mesh/files/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr std::size_t kMaxLineBytes = std::size_t{64} << 10;

struct TypeName {
  std::string_view name;
  ComponentType type;
};
constexpr std::array<TypeName, 16> kTypeNames = {{{"char", ComponentType::kInt8},
                                                  {"int8", ComponentType::kInt8},
                                                  {"uchar", ComponentType::kUint8},
                                                  {"uint8", ComponentType::kUint8},
                                                  {"short", ComponentType::kInt16},
                                                  {"int16", ComponentType::kInt16},
                                                  {"ushort", ComponentType::kUint16},
                                                  {"uint16", ComponentType::kUint16},
                                                  {"int", ComponentType::kInt32},
                                                  {"int32", ComponentType::kInt32},
                                                  {"uint", ComponentType::kUint32},
                                                  {"uint32", ComponentType::kUint32},
                                                  {"float", ComponentType::kFloat32},
                                                  {"float32", ComponentType::kFloat32},
                                                  {"double", ComponentType::kFloat64},
                                                  {"float64", ComponentType::kFloat64}}};

class HeaderReader {
 public:
  explicit HeaderReader(Input& input) : input_(input) {}

  PlyHeader read();

 private:
  /// The words of the next line.
  const std::vector<std::string>& next_line();
  std::size_t find_line_end();
  void read_format();
  void read_element();
  void read_property();
  ComponentType type_from_name(const std::string& name) const;

  [[noreturn]] void refuse(std::string_view expected, std::string_view found) const {
    input_.refuse_at_line(header_.lines,
                          fmt::format("header: expected {}, found {}", expected, found));
  }

  Input& input_;
  PlyHeader header_;
  char terminator_ = '\n';
  std::vector<std::string> words_;
};

std::size_t HeaderReader::find_line_end() {
  for (std::size_t from = 0;;) {
    const std::string_view text = input_.unread();
    const std::size_t end =
        header_.lines == 1 ? text.find_first_of("\r\n", from) : text.find(terminator_, from);
    from = std::min(end, text.size());
    if (from > kMaxLineBytes)
      refuse(fmt::format("lines of at most {} bytes", kMaxLineBytes), "a longer one");
    if (end != std::string_view::npos) return end;
    if (!input_.fill()) refuse("end_header", "the end of the file");
  }
}

const std::vector<std::string>& HeaderReader::next_line() {
  ++header_.lines;
  const std::size_t end = find_line_end();
  if (header_.lines == 1) {
    const bool more = input_.ensure(end + 2);
    const std::string_view text = input_.unread();
    if (text[end] == '\r' && !(more && text[end + 1] == '\n')) terminator_ = '\r';
  }
  words_.clear();
  std::string_view line = input_.unread().substr(0, end);
  constexpr std::string_view kBlanks = " \t\r";
  for (;;) {
    const std::size_t start = line.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) break;
    line.remove_prefix(start);
    words_.emplace_back(line.substr(0, line.find_first_of(kBlanks)));
    line.remove_prefix(words_.back().size());
  }
  input_.consume(end);
  while (input_.unread().front() != terminator_) input_.consume(1);
  input_.consume(1);
  return words_;
}

ComponentType HeaderReader::type_from_name(const std::string& name) const {
  for (const TypeName& known : kTypeNames)
    if (known.name == name) return known.type;
  refuse("a PLY type", in_quotes(name));
}

void HeaderReader::read_format() {
  if (words_.size() != 3 || words_[2] != "1.0")
    refuse("'format NAME 1.0'", words_.size() > 2 ? in_quotes(words_[2]) : "too few words");
  if (words_[1] == "ascii")
    header_.format = PlyFormat::kAscii;
  else if (words_[1] == "binary_little_endian")
    header_.format = PlyFormat::kLittleEndian;
  else if (words_[1] == "binary_big_endian")
    header_.format = PlyFormat::kBigEndian;
  else
    refuse("ascii, binary_little_endian or binary_big_endian", in_quotes(words_[1]));
}

void HeaderReader::read_element() {
  if (words_.size() != 3) refuse("'element NAME COUNT'", fmt::format("{} words", words_.size()));
  PlyElement element;
  element.name = words_[1];
  const std::string& count = words_[2];
  const auto [end, error] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (error != std::errc() || end != count.data() + count.size())
    refuse("a count of elements", in_quotes(count));
  if (element.name == "vertex" || element.name == "face")
    for (const PlyElement& other : header_.elements)
      if (other.name == element.name) refuse("each element once", in_quotes(element.name));
  header_.elements.push_back(std::move(element));
}

void HeaderReader::read_property() {
  if (header_.elements.empty()) refuse("an element before its properties", "a property");
  PlyProperty property;
  property.is_list = words_.size() > 1 && words_[1] == "list";
  const std::size_t expected_words = property.is_list ? 5 : 3;
  if (words_.size() != expected_words)
    refuse("'property TYPE NAME' or 'property list TYPE TYPE NAME'",
           fmt::format("{} words", words_.size()));
  if (property.is_list) property.count_type = type_from_name(words_[2]);
  property.type = type_from_name(words_[expected_words - 2]);
  property.name = words_.back();
  header_.elements.back().properties.push_back(std::move(property));
}

PlyHeader HeaderReader::read() {
  if (next_line() != std::vector<std::string>{"ply"}) refuse("'ply'", "something else");
  bool has_format = false;
  for (;;) {
    if (next_line().empty()) continue;
    const std::string& keyword = words_[0];
    if (keyword == "comment" || keyword == "obj_info") {
      if (words_.size() > 2 && words_[1] == "TextureFile") {
        std::string& name = header_.texture_files.emplace_back(words_[2]);
        for (std::size_t word = 3; word < words_.size(); ++word) name += " " + words_[word];
      }
      continue;
    }
    if (keyword == "end_header") break;
    if (keyword == "format") {
      if (std::exchange(has_format, true)) refuse("one format", "another");
      read_format();
    } else if (keyword == "element") {
      read_element();
    } else if (keyword == "property") {
      read_property();
    } else {
      refuse("format, comment, obj_info, element, property or end_header", in_quotes(keyword));
    }
  }
  if (!has_format) refuse("a format line", "none");
  return std::move(header_);
}

}  // namespace

std::uint64_t PlyElement::least_bytes() const {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += component_bytes(property.is_list ? property.count_type : property.type);
  return bytes;
}

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.is_list; });
}

PlyHeader read_ply_header(Input& input) { return HeaderReader(input).read(); }

PLAIT_END_NAMESPACE
