#include "export/mesh_format.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "base/text.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

struct KnownFormat {
  MeshFormat format;
  std::string_view name, extension;
  bool compressed;  ///< readers also take .gz and .zst
};
constexpr KnownFormat kFormats[] = {
    {MeshFormat::kPly, "PLY", ".ply", true},   {MeshFormat::kObj, "OBJ", ".obj", true},
    {MeshFormat::kStl, "STL", ".stl", true},   {MeshFormat::kOff, "OFF", ".off", true},
    {MeshFormat::kVtp, "VTK", ".vtp", false},  {MeshFormat::kPvtp, "VTK", ".pvtp", false},
    {MeshFormat::kGlb, "glTF", ".glb", false}, {MeshFormat::kGltf, "glTF", ".gltf", false}};

}  // namespace

ExportFormat export_format(const std::filesystem::path& path) {
  ExportFormat found;
  const std::string last = lower_extension(path);
  if (last == ".gz") found.compression = StreamCompression::kGzip;
  if (last == ".zst") found.compression = StreamCompression::kZstd;
  const bool compressed = found.compression != StreamCompression::kNone;
  const std::string extension = compressed ? lower_extension(path.stem()) : last;
  for (const KnownFormat& known : kFormats)
    if (known.extension == extension && (known.compressed || !compressed)) {
      found.mesh = known.format;
      return found;
    }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("export to {}: expected a name that ends in .vtp, .pvtp, .glb or .gltf, "
                          "or in .ply, .obj, .stl or .off, and then .gz, .zst or nothing",
                          path.native()));
}

std::string_view format_name(MeshFormat format) noexcept {
  for (const KnownFormat& known : kFormats)
    if (known.format == format) return known.name;
  return "mesh";
}

bool holds_attribute(MeshFormat format, const AttributeSchema& schema) noexcept {
  const std::size_t bytes = component_bytes(schema.type);
  const bool integer =
      schema.type != ComponentType::kFloat32 && schema.type != ComponentType::kFloat64;
  switch (format) {
    case MeshFormat::kPly:  // has no integers of 64 bits
      return !(integer && bytes == 8);
    case MeshFormat::kObj:
      return schema.name == "normal" && !integer && schema.components == 3;
    case MeshFormat::kStl:
    case MeshFormat::kOff:
      return false;
    case MeshFormat::kVtp:
    case MeshFormat::kPvtp:
      return true;
    case MeshFormat::kGlb:
    case MeshFormat::kGltf:  // has numbers of vertices in 8 and 16 bits and as float, up to four
      return schema.components <= 4 && bytes <= (integer ? 2u : 4u);
  }
  return false;
}

PLAIT_END_NAMESPACE
