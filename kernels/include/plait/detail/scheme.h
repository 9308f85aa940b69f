// plait/detail/scheme.h: subdivision schemes and their properties.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "plait/detail/namespace.h"

PLAIT_BEGIN_NAMESPACE

/// The schemes of the library.
enum class LibraryScheme : std::uint8_t {
  kLoop,       ///< approximating, in place: coarser vertices move with every level
  kButterfly,  ///< modified Butterfly, interpolating
  kMidpoint,   ///< linear
};

class OneRingScheme;

/// A scheme of the library, or a rule of a program's own (plait/own_rule.h):
///
///   subdivide(store, {.scheme = Scheme::kMidpoint});
///   subdivide(store, {.scheme = own_scheme("mine", MyRule{})});
///
/// A value: copies share the rule, and are equal.
class Scheme {
 public:
  // Not `using enum`: GCC 12 fails to compile its names inside templates.
  static constexpr LibraryScheme kLoop = LibraryScheme::kLoop,
                                 kButterfly = LibraryScheme::kButterfly,
                                 kMidpoint = LibraryScheme::kMidpoint;

  Scheme() = default;  ///< Loop
  Scheme(LibraryScheme scheme) : library_(scheme) {}
  Scheme(const OneRingScheme& rule);

  /// The rule of the program's own; nullptr if the scheme is one of the library.
  const OneRingScheme* own() const noexcept { return own_.get(); }
  /// REQUIRES: the scheme is one of the library.
  LibraryScheme of_library() const noexcept { return library_; }
  friend bool operator==(const Scheme&, const Scheme&) = default;

 private:
  LibraryScheme library_ = LibraryScheme::kLoop;
  std::shared_ptr<const OneRingScheme> own_;
};

/// The properties of a scheme.
struct SchemeTraits {
  std::string_view name;    ///< in options, reports and a store's provenance
  int ring_count = 1;       ///< rings around a vertex that a new one depends on
  bool moves_even = false;  ///< every refinement moves the existing vertices
  bool has_limits = false;  ///< limit positions can be computed
};

/// The traits of the schemes of the library: [LibraryScheme]. All schemes have normals: see
/// docs/kernels.md.
std::span<const SchemeTraits> schemes() noexcept;
/// The name in the result is valid as long as a copy of the scheme exists.
SchemeTraits traits_of(const Scheme& scheme);
std::string_view to_string(const Scheme& scheme);
/// "loop, butterfly or midpoint", for help texts and error messages.
std::string scheme_names();
/// The same for the schemes that have limit positions.
std::string limit_scheme_names();
/// Errors: kInvalidArgument; the message lists the known schemes.
LibraryScheme scheme_from_name(std::string_view name);

PLAIT_END_NAMESPACE
