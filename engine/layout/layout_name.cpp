#include "base/text.h"
#include "plait/layout.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

constexpr NameTable<LayoutKind, 5> kLayouts("layout", {{LayoutKind::kGiven, "given"},
                                                       {LayoutKind::kSpatial, "spatial"},
                                                       {LayoutKind::kHilbert, "hilbert"},
                                                       {LayoutKind::kRcm, "rcm"},
                                                       {LayoutKind::kAutomatic, "auto"}});

}  // namespace

std::string_view to_string(LayoutKind kind) noexcept { return kLayouts.name_of(kind); }

LayoutKind layout_from_name(std::string_view name) { return kLayouts.find(name); }

PLAIT_END_NAMESPACE
