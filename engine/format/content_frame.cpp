#define ZSTD_STATIC_LINKING_ONLY  // ZSTD_c_stableInBuffer
#include "format/content_frame.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

/// Faster than a disk. Small meshes, which are packed in no time, are a larger part of their
/// stores.
constexpr int kZstdLevel = 3, kZstdLevelOfSmall = 19;
constexpr std::uint64_t kSmallBytes = 512u << 10;

}  // namespace

struct ContentFrame::State {
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context{ZSTD_createCCtx(), &ZSTD_freeCCtx};
  std::vector<std::byte> out = std::vector<std::byte>(ZSTD_CStreamOutSize());
  ZSTD_inBuffer in = {};
  std::string name;

  void check(std::size_t result) const {
    if (ZSTD_isError(result))
      throw Error(ErrorCode::kOutOfMemory,
                  fmt::format("create {}: zstd: {}", name, ZSTD_getErrorName(result)));
  }
};

ContentFrame::ContentFrame(const std::byte* content, std::uint64_t bytes, std::string_view name)
    : state_(std::make_unique<State>()), content_(content), bytes_(bytes) {
  ZSTD_CCtx* const context = state_->context.get();
  if (context == nullptr)
    throw Error(ErrorCode::kOutOfMemory, fmt::format("create {}: no memory for zstd", name));
  state_->name = name;
  const auto check = [&](std::size_t result) { state_->check(result); };
  check(ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel,
                               bytes <= kSmallBytes ? kZstdLevelOfSmall : kZstdLevel));
  // The compressor then copies no content, and its window is what is before: so the frame is that
  // of one call for the whole content.
  check(ZSTD_CCtx_setParameter(context, ZSTD_c_stableInBuffer, 1));
  check(ZSTD_CCtx_setPledgedSrcSize(context, bytes));
  state_->in.src = content;
}

ContentFrame::~ContentFrame() = default;

void ContentFrame::add(std::vector<std::byte>& frame) {
  State& state = *state_;
  done_ = std::min(bytes_, done_ + kStepBytes);
  is_done_ = done_ == bytes_;
  state.in.size = done_;
  std::size_t left = 1;
  while (is_done_ ? left > 0 : state.in.pos < state.in.size) {
    ZSTD_outBuffer out = {state.out.data(), state.out.size(), 0};
    left = ZSTD_compressStream2(state.context.get(), &out, &state.in,
                                is_done_ ? ZSTD_e_end : ZSTD_e_continue);
    state.check(left);
    frame.insert(frame.end(), state.out.data(), state.out.data() + out.pos);
    if (!is_done_ && out.pos == 0) break;  // it waits for a whole block
  }
}

PLAIT_END_NAMESPACE
