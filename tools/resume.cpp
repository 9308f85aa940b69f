#include "resume.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "plait/error.h"

namespace plait {
namespace {

[[noreturn]] void refuse(const Store& store, const std::string& reason) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("resume {}: {}", store.path().native(), reason));
}

}  // namespace

Store open_to_resume(const std::filesystem::path& path, const OpenOptions& open,
                     const SubdivideOptions& subdivision, bool double_precision,
                     const BackendRegistry& backends) {
  Store store = Store::open(path, open, backends);
  const Provenance& provenance = store.provenance();
  if (provenance.limit)
    refuse(store, "it holds limit positions, from which no subdivision can go on");
  const bool has_levels = store.finest_level() > store.base_level();
  if (has_levels && provenance.scheme != to_string(subdivision.scheme))
    refuse(store, fmt::format("expected a store of scheme \"{}\", found \"{}\"",
                              to_string(subdivision.scheme), provenance.scheme));
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  const ComponentType type = double_precision ? ComponentType::kFloat64 : ComponentType::kFloat32;
  if (position.schema.type != type)
    refuse(store, fmt::format("expected positions of {}, found {}", to_string(type),
                              to_string(position.schema.type)));
  if (position.finest_level > subdivision.levels)
    refuse(store, fmt::format("expected level {} at most, found level {}", subdivision.levels,
                              position.finest_level));
  if (store.has_attribute("normal") && position.finest_level < subdivision.levels)
    refuse(store,
           fmt::format("expected positions alone, found normals: it was finished at level {}",
                       position.finest_level));
  return store;
}

void require_same_mesh(const Store& store, const BaseMesh& mesh) {
  if (!std::ranges::equal(store.base().faces(), mesh.faces()) ||
      !std::ranges::equal(store.base().positions(), mesh.positions(),
                          [](const Vector3<double>& a, const Vector3<double>& b) {
                            return a.x == b.x && a.y == b.y && a.z == b.z;
                          }))
    refuse(store, "its base mesh is another one than the mesh that was given");
}

bool is_finished(const Store& store, const SubdivideOptions& subdivision) {
  const AttributeInfo& position = store.attributes()[store.attribute("position")];
  return position.finest_level == subdivision.levels &&
         (!subdivision.normals || store.has_attribute("normal"));
}

}  // namespace plait
