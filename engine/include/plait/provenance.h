// plait/provenance.h: where the content of a store comes from: enough to make it again.
#pragma once

#include <string>

#include "plait/attribute.h"

namespace plait {

/// Recorded by every commit. Names are printable ASCII, at most 64 KiB each. `layout` and
/// `base_level` are said when the store is created; the rest is what made the levels of attribute
/// "position", and subdivide() says it.
struct Provenance {
  /// "loop", "butterfly", "midpoint" or a name of one's own. Empty: no level was made, or what made
  /// them is not known, or was not one thing.
  std::string scheme = {};
  bool limit = false;  ///< positions were projected to the scheme's limit surface afterwards
  ComponentType precision = ComponentType::kFloat32;  ///< of the arithmetic: float32 or float64
  std::string layout = "given";                       ///< the order of the base mesh
  int base_level = 0;                                 ///< see Store::base_level()
  std::string program = {};                           ///< version of plait that made the levels

  friend bool operator==(const Provenance&, const Provenance&) = default;
};

/// The version of this library, such as "0.1.0".
std::string program_version();

}  // namespace plait
