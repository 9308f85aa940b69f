// plait/kernels/scheme.h: the subdivision schemes that the library has, and what each can do.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace plait {

enum class Scheme : std::uint8_t {
  kLoop,       ///< approximating, in place: coarser vertices move with every level
  kButterfly,  ///< modified Butterfly, interpolating
  kMidpoint,   ///< linear
};

struct SchemeTraits {
  std::string_view name;    ///< in options, reports and a store's provenance
  int reach = 1;            ///< rings around a vertex that a new one depends on
  bool moves_even = false;  ///< every refinement moves the vertices that are there
  bool has_limits = false;  ///< limit positions can be computed
};

/// Traits of all schemes: [Scheme]. Normals are defined for each: see docs/kernels.md.
std::span<const SchemeTraits> schemes() noexcept;
const SchemeTraits& traits_of(Scheme scheme) noexcept;
std::string_view to_string(Scheme scheme) noexcept;
/// "loop, butterfly or midpoint", for helps and errors.
std::string scheme_names();
/// Errors: kInvalidArgument naming the schemes there are.
Scheme scheme_from_name(std::string_view name);

}  // namespace plait
