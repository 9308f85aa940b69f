#include "prune/prune.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "plait/detail/face_depths.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "prune/balance.h"
#include "prune/distance_depths.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// A number of a face attribute of integers that are not negative.
std::uint64_t number_at(std::span<const std::byte> bytes, std::size_t size, FaceId face) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + face * size, size);  // little-endian, as all of plait
  return number;
}

bool is_unsigned(ComponentType type) {
  return type == ComponentType::kUint8 || type == ComponentType::kUint16 ||
         type == ComponentType::kUint32 || type == ComponentType::kUint64;
}

std::vector<std::uint8_t> depths_by(const Store& source, const std::string& name) {
  const std::span<const std::byte> bytes = source.notes().face_bytes(name);
  const ComponentType type =
      std::ranges::find(source.notes().face_attributes(), name, &AttributeSchema::name)->type;
  if (!is_unsigned(type))
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("prune {} by '{}': expected integers that are not negative, of type uint8 to "
                    "uint64, found {}",
                    source.path().native(), name, to_string(type)));
  const std::uint64_t faces = source.base().face_count();
  std::vector<std::uint8_t> depths(faces);
  for (FaceId face = 0; face < faces; ++face) {
    const std::uint64_t level = number_at(bytes, bytes.size() / faces, face);
    if (level < static_cast<std::uint64_t>(source.base_level()) ||
        level > static_cast<std::uint64_t>(source.finest_level()))
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("prune {} by '{}': face {}: expected a level from {} to {}, found {}",
                              source.path().native(), name, face, source.base_level(),
                              source.finest_level(), level));
    depths[face] =
        static_cast<std::uint8_t>(level - static_cast<std::uint64_t>(source.base_level()));
  }
  return depths;
}

}  // namespace

PruneResult prune(const PruneRequest& request, const BackendRegistry& source_backends,
                  const BackendRegistry& backends, const JobWatch& watch) {
  const int choices = (request.depth_by.empty() ? 0 : 1) + (request.max_distance ? 1 : 0) +
                      (request.vertices == 0 ? 0 : 1);
  if (choices != 1)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("prune: expected one of max-distance, vertices and depth-by, which say "
                            "how deep faces are, found {}",
                            choices));
  PruneResult result;
  ConversionRequest copy = request.copy;
  copy.verb = "prune";
  copy.base = [&](Store& source) {
    StoreAccess::refuse_depths(source, "prune", source.finest_level());
    result.from_vertices = vertices_of(source);
    const Topology mesh = source.base().topology();
    std::vector<std::uint8_t> depths;
    if (!request.depth_by.empty()) {
      depths = depths_by(source, request.depth_by);
      result.raised = balance_depths(mesh, request.balance, depths);
    } else {
      DistanceDepths found =
          request.vertices > 0
              ? depths_by_vertices(source, request.vertices, request.balance, watch)
              : depths_by_distance(source, *request.max_distance, request.balance, watch);
      depths = std::move(found.depths);
      result.raised = found.raised;
      if (request.vertices == 0) result.tolerance = found.tolerance;
      result.distance = found.distance;
    }
    const auto base_level = static_cast<std::size_t>(source.base_level());
    for (const std::uint8_t depth : depths) ++result.faces_of_level[base_level + depth];
    return source.base().with_depths(std::move(depths));
  };
  result.copy = convert(copy, source_backends, backends, watch);
  return result;
}

PLAIT_END_NAMESPACE
