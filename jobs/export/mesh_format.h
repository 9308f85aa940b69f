// export/mesh_format.h: the kinds of files that an export writes, and what each of them can hold.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

#include "export/output_stream.h"
#include "plait/attribute.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class MeshFormat : std::uint8_t { kPly, kObj, kStl, kOff, kVtp, kPvtp, kGlb, kGltf };

struct ExportFormat {
  MeshFormat mesh = MeshFormat::kPly;
  StreamCompression compression = StreamCompression::kNone;
};
/// The format that a name NAME.(ply|obj|stl|off)[.gz|.zst] or NAME.(vtp|pvtp|glb|gltf) stands for.
/// Errors: kInvalidArgument; the message lists the known endings.
ExportFormat export_format(const std::filesystem::path& path);

/// "PLY", "glTF".
std::string_view format_name(MeshFormat format) noexcept;
constexpr bool is_gltf(MeshFormat format) noexcept {
  return format == MeshFormat::kGlb || format == MeshFormat::kGltf;
}
/// VTK's files for polygons.
constexpr bool is_vtk(MeshFormat format) noexcept {
  return format == MeshFormat::kVtp || format == MeshFormat::kPvtp;
}
/// Whether a file can hold such an attribute of vertices beside the positions.
bool holds_attribute(MeshFormat format, const AttributeSchema& schema) noexcept;
/// Whether a file can hold attributes of triangles.
constexpr bool holds_face_attributes(MeshFormat format) noexcept {
  return format == MeshFormat::kPly || is_vtk(format);
}

PLAIT_END_NAMESPACE
