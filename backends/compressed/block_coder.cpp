#include "compressed/block_coder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "compressed/codec_time.h"
#include "plait/error.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

std::size_t scratch_bytes(const Filters& filters) noexcept {
  std::size_t most = 0;
  for (const auto& filter : filters) most = std::max(most, filter->scratch_bytes());
  return most;
}

bool need_other_blocks(const Filters& filters) noexcept {
  return !filters.empty() && filters.front()->needs_other_blocks();
}

bool keep_note(const Filters& filters) noexcept {
  return !filters.empty() && filters.front()->keeps_note();
}

BlockCoder::BlockCoder(std::unique_ptr<Codec> codec, std::uint64_t max_raw_bytes,
                       std::size_t buffers, std::size_t scratch_bytes)
    : codec_(std::move(codec)),
      max_raw_bytes_(max_raw_bytes),
      buffers_(buffers),
      scratch_bytes_(scratch_bytes) {}

std::uint64_t BlockCoder::memory_bytes() const {
  return max_encoded_bytes(max_raw_bytes_) + buffers_ * max_raw_bytes_ + scratch_bytes_ +
         codec_->memory_bytes(max_raw_bytes_);
}

void BlockCoder::make_room() {
  for (std::size_t i = 0; i < buffers_; ++i) filtered_[i].resize(max_raw_bytes_);
  stored_.resize(max_encoded_bytes(max_raw_bytes_));
  scratch_.resize(scratch_bytes_);
}

FilterBlock BlockCoder::with_scratch(const FilterBlock& block, std::byte* note) {
  return {block.block, block.context, scratch_, note};
}

EncodedBlock BlockCoder::encode(const CodedBlock& block, std::span<const std::byte> raw) {
  const CodecTimer timer;
  make_room();
  std::byte note{};
  const FilterBlock with = with_scratch(block.block, &note);
  std::span<const std::byte> source = raw;
  for (std::size_t i = 0; i < block.filters.size(); ++i) {
    const std::span<std::byte> filtered(filtered_[i % 2].data(), raw.size());
    block.filters[i]->encode(with, source, filtered);
    source = filtered;
  }
  const std::span<std::byte> target(stored_.data(), max_encoded_bytes(raw.size()));
  const std::size_t seal_bytes = block.context_seal ? sizeof(*block.context_seal) : 0;
  const std::size_t head_bytes = seal_bytes + (keep_note(block.filters) ? 1 : 0);
  if (target.size() <= head_bytes) return {BlockEncoding::kRaw, raw};
  const auto stored_bytes = codec_->compress(source, target.subspan(head_bytes));
  if (!stored_bytes || *stored_bytes == 0) return {BlockEncoding::kRaw, raw};
  if (block.context_seal) std::memcpy(target.data(), &*block.context_seal, seal_bytes);
  if (head_bytes > seal_bytes) target[seal_bytes] = note;
  return {BlockEncoding::kEncoded, target.first(head_bytes + *stored_bytes)};
}

std::span<std::byte> BlockCoder::stored_buffer(std::uint64_t stored_bytes) {
  make_room();
  return std::span(stored_).first(stored_bytes);
}

void BlockCoder::decode(const CodedBlock& block, std::span<const std::byte> stored,
                        std::span<std::byte> raw) {
  const CodecTimer timer;
  make_room();
  if (block.context_seal) {
    std::uint64_t found = 0;
    if (stored.size() >= sizeof found) std::memcpy(&found, stored.data(), sizeof found);
    if (stored.size() < sizeof found || found != *block.context_seal)
      throw Error(ErrorCode::kCorruption,
                  fmt::format("the blocks that it was encoded from have changed: expected their "
                              "seal {:016x}, found {:016x}",
                              found, *block.context_seal));
    stored = stored.subspan(sizeof found);
  }
  std::byte note{};
  if (keep_note(block.filters)) {
    if (stored.empty())
      throw Error(ErrorCode::kCorruption, "expected a note before the codec's bytes, found none");
    note = stored.front();
    stored = stored.subspan(1);
  }
  const FilterBlock with = with_scratch(block.block, &note);
  if (block.filters.empty()) return codec_->decompress(stored, raw);
  std::size_t stage = block.filters.size() - 1;
  std::span<std::byte> source(filtered_[stage % 2].data(), raw.size());
  codec_->decompress(stored, source);
  for (; stage > 0; --stage) {
    const std::span<std::byte> target(filtered_[(stage - 1) % 2].data(), raw.size());
    block.filters[stage]->decode(with, source, target);
    source = target;
  }
  block.filters[0]->decode(with, source, raw);
}

PLAIT_END_NAMESPACE
