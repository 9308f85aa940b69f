#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fused/builtin_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fused/patch_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

PatchRows<float> loop_float() { return patch_rows<LoopRule, float>(); }
PatchRows<double> loop_double() { return patch_rows<LoopRule, double>(); }
PatchRows<float> midpoint_float() { return patch_rows<MidpointRule, float>(); }
PatchRows<double> midpoint_double() { return patch_rows<MidpointRule, double>(); }

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "fused/surface_refiner.h"

namespace plait {
namespace fused_rows {

HWY_EXPORT(loop_float);
HWY_EXPORT(loop_double);
HWY_EXPORT(midpoint_float);
HWY_EXPORT(midpoint_double);

}  // namespace fused_rows

template <>
fused_rows::PatchRows<float> loop_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(loop_float)();
}
template <>
fused_rows::PatchRows<double> loop_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(loop_double)();
}
template <>
fused_rows::PatchRows<float> midpoint_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(midpoint_float)();
}
template <>
fused_rows::PatchRows<double> midpoint_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(midpoint_double)();
}

}  // namespace plait
#endif
