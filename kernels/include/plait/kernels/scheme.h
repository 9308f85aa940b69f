// plait/kernels/scheme.h: the subdivision schemes of the library and their properties.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "plait/namespace.h"

PLAIT_BEGIN_NAMESPACE

enum class Scheme : std::uint8_t {
  kLoop,       ///< approximating, in place: coarser vertices move with every level
  kButterfly,  ///< modified Butterfly, interpolating
  kMidpoint,   ///< linear
};
/// The scheme of a subdivision if nobody names one.
inline constexpr Scheme kDefaultScheme = Scheme::kLoop;

/// The properties of a scheme of the library.
struct SchemeTraits {
  std::string_view name;    ///< in options, reports and a store's provenance
  int reach = 1;            ///< rings around a vertex that a new one depends on
  bool moves_even = false;  ///< every refinement moves the existing vertices
  bool has_limits = false;  ///< limit positions can be computed
};

/// The traits of all schemes: [Scheme]. All schemes have normals: see docs/kernels.md.
std::span<const SchemeTraits> schemes() noexcept;
const SchemeTraits& traits_of(Scheme scheme) noexcept;
std::string_view to_string(Scheme scheme) noexcept;
/// "loop, butterfly or midpoint", for help texts and error messages.
std::string scheme_names();
/// The same for the schemes that have limit positions.
std::string limit_scheme_names();
/// Errors: kInvalidArgument; the message lists the known schemes.
Scheme scheme_from_name(std::string_view name);

PLAIT_END_NAMESPACE
