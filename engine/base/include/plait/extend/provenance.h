// plait/extend/provenance.h: how the levels of a store were made, in enough detail to make them
// again.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "plait/attribute.h"
#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// Every commit records it. Names are printable ASCII, at most 64 KiB each. `layout` and
/// `base_level` are facts about the base mesh: Store::create() gets them, and they never change.
/// subdivide() sets the other members; they describe how the levels of attribute "position" were
/// made.
struct Provenance {
  /// "loop", "butterfly", "midpoint" or the name of a program's own scheme. Empty: there is no
  /// level, or the scheme is not known, or different levels have different schemes.
  std::string scheme = {};
  bool limit = false;  ///< positions were projected to the scheme's limit surface afterwards
  ComponentType precision = ComponentType::kFloat32;  ///< of the arithmetic: float32 or float64
  std::string layout = "given";                       ///< the order of the base mesh, by name
  int base_level = 0;        ///< see Store::base_level(); rebase() makes such a base mesh
  std::string program = {};  ///< version of plait that made the levels

  friend bool operator==(const Provenance&, const Provenance&) = default;
};

/// What people note about a store, by name: units, coordinate system, author. Each commit records
/// them, and the library reads none of them.
using Texts = std::map<std::string, std::string, std::less<>>;

/// The version of this library, such as "0.1.0".
std::string program_version();

PLAIT_END_NAMESPACE
