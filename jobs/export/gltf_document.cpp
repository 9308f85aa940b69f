#include "export/gltf_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "plait/reader.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

// 65,535 as an index is kept for other uses, so it numbers no vertex.
constexpr std::uint64_t kMostOf16Bits = 65535;
// Files may have 4 GiB, but many readers have numbers of 31 bits, or arrays of at most 2 GiB.
constexpr std::uint64_t kMostBytes = 0x7fffffff;
constexpr double kLongestNumber = -1.2345678901234567e-308;

int gltf_component(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8:
      return 5120;
    case ComponentType::kUint8:
      return 5121;
    case ComponentType::kInt16:
      return 5122;
    case ComponentType::kUint16:
      return 5123;
    default:
      return 5126;
  }
}

std::string_view shape_name(std::uint32_t components) {
  constexpr std::string_view kNames[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
  return kNames[components - 1];
}

std::string numbers(const GltfVector& point) {
  return fmt::format("[{},{},{}]", point[0], point[1], point[2]);
}

std::size_t whole_words(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

}  // namespace

GltfDocument::GltfDocument(const ExportTask& task, const GltfPlacement& placement, bool normals)
    : task_(&task),
      placement_(&placement),
      patch_vertices_(patch_vertex_count(std::int64_t{1} << task.patches.refinements())) {
  const std::uint64_t patches = task.patches.faces().size();
  if (!has_equal_patches()) {
    patches_of_group_ = patches;
    index_bytes_ = vertices() <= kMostOf16Bits ? 2 : 4;
  } else if (patch_vertices_ <= kMostOf16Bits) {
    patches_of_group_ = std::min(kMostOf16Bits / patch_vertices_, patches);
    index_bytes_ = 2;
  }
  group_count_ = (patches - 1) / patches_of_group_ + 1;
  total_bytes_ = whole_words(group_indices(0) * index_bytes_);
  add_column(task.position, normals);
  for (const AttributeId id : task.extras) add_column(id, normals);
  if (total_bytes_ + most_text_bytes({}) > kMostBytes)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("export {}: level {} of {} patches takes {:.1f} GiB, but glTF files "
                            "have at most 2 GiB; take a coarser --level, a --box{}",
                            task.store.path().native(), task.level, patches,
                            static_cast<double>(total_bytes_) / (1 << 30),
                            placement.lattice ? "" : ", or --quantize"));
}

void GltfDocument::describe_color(GltfColumn& column, ComponentType type) const {
  const std::string& asked = task_->request.colors;
  const bool bytes = type == ComponentType::kUint8, words = type == ComponentType::kUint16;
  column.semantic = "COLOR_0";
  column.srgb = asked == "srgb" || (asked.empty() && (bytes || words));
  column.normalized = bytes || (words && !column.srgb);
  if (!column.srgb && (bytes || words)) return;
  // Linear numbers are close together in the dark: 8 bits would be too few of them.
  column.conversion = GltfConversion::kColor;
  column.component = gltf_component(bytes ? ComponentType::kUint16 : ComponentType::kFloat32);
  column.stride = whole_words(column.components * (bytes ? sizeof(std::uint16_t) : sizeof(float)));
}

void GltfDocument::add_column(AttributeId attribute, bool normals) {
  const AttributeSchema& schema = task_->schema(attribute);
  GltfColumn column;
  column.attribute = attribute;
  column.semantic = "_" + schema.name;
  column.component = gltf_component(schema.type);
  column.components = schema.components;
  column.stride = whole_words(schema.record_bytes());
  column.offset = total_bytes_;
  const bool wide = schema.type == ComponentType::kFloat64;
  const bool real = schema.type == ComponentType::kFloat32 || wide;
  const bool small = schema.type == ComponentType::kUint8 || schema.type == ComponentType::kUint16;
  const bool quantize = placement_->lattice;
  if (wide) {
    column.conversion = GltfConversion::kNarrow;
    column.stride = schema.components * sizeof(float);
  }
  if (attribute == task_->position) {
    column.semantic = "POSITION";
    column.conversion = quantize ? GltfConversion::kLattice : GltfConversion::kPosition;
    if (quantize) {
      column.component = gltf_component(ComponentType::kUint16);
      column.stride = whole_words(3 * sizeof(std::uint16_t));
    }
  } else if (schema.name == "normal" && real && schema.components == 3) {
    if (!normals) return;
    column.semantic = "NORMAL";
    column.conversion = quantize ? GltfConversion::kUnitBytes : GltfConversion::kUnit;
    if (quantize) {
      column.component = gltf_component(ComponentType::kInt8);
      column.normalized = true;
      column.stride = 4;
    }
  } else if (schema.name == "color" && (real || small) && schema.components >= 3) {
    describe_color(column, schema.type);
  } else if (schema.name == "texture" && real && schema.components == 2) {
    column.semantic = "TEXCOORD_0";
    column.conversion = GltfConversion::kTexture;
  }
  total_bytes_ += column.stride * vertices();
  columns_.push_back(column);
}

std::span<const FaceId> GltfDocument::group(std::uint64_t number) const {
  const std::span<const FaceId> faces = task_->patches.faces();
  const std::uint64_t first = number * patches_of_group_;
  return faces.subspan(first, std::min<std::uint64_t>(patches_of_group_, faces.size() - first));
}

std::string GltfDocument::accessors(std::span<const GltfBounds> bounds) const {
  // The indices of a whole group, and those of the last one if it is shorter.
  std::string text;
  for (std::uint64_t at = 0; at < index_lists(); ++at) {
    const std::uint64_t number = at == 0 ? 0 : group_count_ - 1;
    text +=
        fmt::format("{}{{\"bufferView\":0,\"componentType\":{},\"count\":{},\"type\":\"SCALAR\"}}",
                    at == 0 ? "" : ",", index_bytes_ == 2 ? 5123 : 5125, group_indices(number));
  }
  for (std::size_t at = 0; at < columns_.size(); ++at) {
    const GltfColumn& column = columns_[at];
    std::uint64_t vertex = 0;
    for (std::uint64_t number = 0; number < group_count_; ++number) {
      text += fmt::format(
          ",{{\"bufferView\":{},\"byteOffset\":{},\"componentType\":{},{}\"count\":{},"
          "\"type\":\"{}\"",
          at + 1, vertex * column.stride, column.component,
          column.normalized ? "\"normalized\":true," : "", group_vertices(number),
          shape_name(column.components));
      if (at == 0)
        text += fmt::format(",\"min\":{},\"max\":{}", numbers(bounds[number].low),
                            numbers(bounds[number].high));
      text += '}';
      vertex += group_vertices(number);
    }
  }
  return text;
}

std::string GltfDocument::primitives() const {
  std::string text;
  for (std::uint64_t number = 0; number < group_count_; ++number) {
    text += fmt::format("{}{{\"attributes\":{{", number == 0 ? "" : ",");
    for (std::size_t at = 0; at < columns_.size(); ++at)
      text += fmt::format("{}\"{}\":{}", at == 0 ? "" : ",", columns_[at].semantic,
                          index_lists() + at * group_count_ + number);
    text += fmt::format("}},\"indices\":{}}}", number + 1 == group_count_ ? index_lists() - 1 : 0);
  }
  return text;
}

std::string GltfDocument::views() const {
  std::string text = fmt::format("{{\"buffer\":0,\"byteLength\":{},\"target\":34963}}",
                                 group_indices(0) * index_bytes_);
  for (const GltfColumn& column : columns_)
    text += fmt::format(
        ",{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{},\"byteStride\":{},\"target\":34962}"
        "}",
        column.offset, column.stride * vertices(), column.stride);
  return text;
}

std::string GltfDocument::text(std::span<const GltfBounds> bounds, std::string_view uri) const {
  std::string node = "{\"mesh\":0";
  std::string extensions;
  if (placement_->moves)
    node += fmt::format(",\"translation\":{}", numbers(placement_->translation));
  if (placement_->lattice) {
    const double step = placement_->step;
    node += fmt::format(",\"scale\":{}", numbers({step, step, step}));
    extensions =
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],"
        "\"extensionsRequired\":[\"KHR_mesh_quantization\"],";
  }
  std::string buffer = fmt::format("{{\"byteLength\":{}", total_bytes_);
  if (!uri.empty()) buffer += fmt::format(",\"uri\":\"{}\"", uri);
  return fmt::format(
      "{{\"asset\":{{\"version\":\"2.0\",\"generator\":\"plait\"}},{}\"scene\":0,"
      "\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{}}}],\"meshes\":[{{\"primitives\":[{}]}}],"
      "\"accessors\":[{}],\"bufferViews\":[{}],\"buffers\":[{}}}]}}",
      extensions, node, primitives(), accessors(bounds), views(), buffer);
}

std::size_t GltfDocument::most_text_bytes(std::string_view uri) const {
  const GltfVector point = {kLongestNumber, kLongestNumber, kLongestNumber};
  const std::vector<GltfBounds> longest(group_count_, {point, point});
  return text(longest, uri).size();
}

PLAIT_END_NAMESPACE
