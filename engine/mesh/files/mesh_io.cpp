#include "plait/mesh_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "base/text.h"
#include "mesh/connectivity.h"
#include "mesh/files/readers.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

using Reader = AttributedMesh (*)(Input&, Reading&);

/// The extension of the format, without that of the compression.
std::string format_extension(const std::filesystem::path& path) {
  const std::string last = lower_extension(path);
  return last == ".gz" || last == ".zst" ? lower_extension(path.stem()) : last;
}

/// "ply" alone on its line. The header of a binary STL file may begin with the word too.
bool is_ply(std::string_view start) {
  if (!start.starts_with("ply")) return false;
  const std::size_t end = start.find_first_not_of(" \t", 3);
  return end != std::string_view::npos && (start[end] == '\n' || start[end] == '\r');
}

/// Passes the mark that some editors put before a text.
void pass_byte_order_mark(Input& input) {
  constexpr std::string_view kUtf8 = "\xef\xbb\xbf", kUtf16Little = "\xff\xfe",
                             kUtf16Big = "\xfe\xff";
  input.ensure(kUtf8.size());
  const std::string_view start = input.unread();
  if (start.starts_with(kUtf16Little) || start.starts_with(kUtf16Big))
    input.refuse_at_byte(0, "expected text of one byte for each letter, found UTF-16");
  if (start.starts_with(kUtf8)) input.consume(kUtf8.size());
}

Reader find_reader(Input& input) {
  constexpr std::size_t kLookBytes = 16;
  const std::string extension = format_extension(input.path());
  if (extension == ".stl" && is_binary_stl(input)) return read_stl;
  pass_byte_order_mark(input);
  input.ensure(kLookBytes);
  const std::string_view start = input.unread().substr(0, kLookBytes);
  const std::string_view word = start.substr(0, start.find_first_of(" \t\r\n#"));
  if (is_ply(start)) return read_ply;
  if (off_keyword_bytes(word) > 0) return read_off;
  if (extension == ".obj") return read_obj;
  if (extension == ".off") return read_off;
  if (extension == ".stl" && !start.empty()) return read_stl;
  input.refuse_at_byte(
      0, fmt::format("expected PLY or OFF content or a name that ends in .obj or .stl, found {}",
                     start.empty() ? "an empty file" : in_quotes(start)));
}

template <class Element>
void release_excess(std::vector<Element>& elements) {
  if (elements.capacity() - elements.size() > elements.size() / 8) elements.shrink_to_fit();
}

/// Names of a file may be of any length and have any bytes.
std::string short_line(std::string text) {
  constexpr std::size_t kMostBytes = 600;
  if (text.size() > kMostBytes) text.replace(kMostBytes, std::string::npos, "...");
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

/// How to keep what is left out; empty if there is no way.
std::string_view way_to_keep(bool is_ply, const Reading& reading) {
  if (!reading.attributes) return " (only positions and faces are read here)";
  if (!reading.leaves_out_of_vertices) return "";
  return is_ply ? " (scalar properties of vertices are kept)"
                : " (a PLY file can have numbers of vertices as properties, which are kept)";
}

AttributedMesh read_mesh(Input& input, Reading reading) {
  const Reader reader = find_reader(input);
  if (reading.sink != nullptr && reader != read_ply)
    throw Error(ErrorCode::kNotSupported,
                fmt::format("read {}: expected a PLY file, which can be read in parts: others are "
                            "read into memory as a whole",
                            input.path().native()))
        .about(input.path());
  AttributedMesh read = reader(input, reading);
  if (const std::uint64_t bytes = input.padding_bytes(); bytes > 0)
    reading.warn(fmt::format("{}: {} {} of zeros or ^Z behind the text ignored",
                             input.path().native(), bytes, bytes == 1 ? "byte" : "bytes"));
  if (!reading.left_out.empty())
    reading.warn(fmt::format("{}: left out: {}{}", input.path().native(),
                             short_line(fmt::format("{}", fmt::join(reading.left_out, "; "))),
                             way_to_keep(reader == read_ply, reading)));
  release_excess(read.mesh.positions);
  release_excess(read.mesh.faces);
  for (auto* const attributes : {&read.attributes, &read.face_attributes})
    for (MeshAttribute& attribute : *attributes) release_excess(attribute.records);
  return read;
}

}  // namespace

void Reading::leave_out(std::uint64_t number, std::string_view one, std::string_view many) {
  if (number > 0) left_out.push_back(fmt::format("{} {}", number, number == 1 ? one : many));
}

void Reading::leave_out_of(std::string_view what, std::uint64_t number, std::string_view one,
                           std::string_view many) {
  if (number > 0)
    left_out.push_back(fmt::format("{} of {} {}", what, number, number == 1 ? one : many));
}

void Reading::leave_out_of_vertices(std::string_view what, std::uint64_t number) {
  leave_out_of(what, number, "vertex", "vertices");
  leaves_out_of_vertices = leaves_out_of_vertices || number > 0;
}

void stream_mesh(const std::filesystem::path& path, MeshSink& sink, Warnings* warnings) {
  with_memory_errors("read " + path.native(), [&] {
    Input input(path);
    return read_mesh(input, {.sink = &sink, .warnings = warnings}).mesh.faces.empty();
  });
}

IndexedMesh read_indexed_mesh(const std::filesystem::path& path, Warnings* warnings) {
  return with_memory_errors("read " + path.native(), [&] {
    Input input(path);
    return std::move(read_mesh(input, {.attributes = false, .warnings = warnings}).mesh);
  });
}

AttributedMesh read_attributed_mesh(const std::filesystem::path& path, Warnings* warnings,
                                    NotFinite not_finite, OfFaces of_faces) {
  return with_memory_errors("read " + path.native(), [&] {
    Input input(path);
    input.keep_not_finite(not_finite == NotFinite::kKeep);
    return read_mesh(
        input,
        {.attributes = true, .face_attributes = of_faces == OfFaces::kKeep, .warnings = warnings});
  });
}

BaseMesh read_base_mesh(const std::filesystem::path& path, Warnings* warnings) {
  IndexedMesh mesh = read_indexed_mesh(path, warnings);
  try {
    return BaseMesh::build(std::move(mesh), path.native(), warnings);
  } catch (const Error& error) {
    throw Error(error).about(path);
  }
}

PLAIT_END_NAMESPACE
