#include "tune/choice.h"

#include <fmt/format.h>

#include <algorithm>

#include "plait/extend/store_access.h"

namespace plait::tune {

Compression compression_of(const Choice& choice) {
  Compression compression;
  for (const std::string& text : choice.compress) compression.add(text);
  return compression;
}

std::string Choice::options() const {
  std::string text = compress.empty() ? "--backend " + backend : "";
  for (const std::string& value : compress)
    text += fmt::format("{}--compress {}", text.empty() ? "" : " ", value);
  return block_bytes == 0 ? text : fmt::format("{} --block {}KiB", text, block_bytes >> 10);
}

Choice choice_of_preset(const std::string& preset, const std::string& raw_backend) {
  if (preset == "none")
    return {.name = preset, .compress = {}, .is_preset = true, .backend = raw_backend};
  return {.name = preset, .compress = {preset}, .is_preset = true};
}

Choice choice_of_pipelines(const std::vector<std::string>& names,
                           const std::vector<Pipeline>& pipelines) {
  Choice choice;
  for (std::size_t at = 0; at < names.size(); ++at) {
    choice.compress.push_back(fmt::format("{}={}", names[at], pipelines[at].to_text()));
    choice.name += fmt::format("{}{}", at == 0 ? "" : "; ", choice.compress.back());
  }
  return choice;
}

StoreOptions options_of_copy(const Store& source, const Choice& choice) {
  StoreOptions options = source.options();
  options.backend = choice.backend;
  options.pipeline = {};
  options.pipeline_of = {};
  options.durability = Durability::kCommit;
  if (choice.block_bytes > 0) options.block_bytes = choice.block_bytes;
  if (!choice.compress.empty())
    options.pipeline_of = [compression = compression_of(choice)](const AttributeSchema& schema) {
      return compression.pipeline_of(schema);
    };
  return options;
}

Pipeline pipeline_of(const Choice& choice, const AttributeSchema& schema) {
  return choice.compress.empty() ? Pipeline() : compression_of(choice).pipeline_of(schema).of(0);
}

bool store_alike(const Choice& a, const Choice& b, const std::vector<AttributeSchema>& attributes) {
  return a.block_bytes == b.block_bytes &&
         std::ranges::all_of(attributes, [&](const AttributeSchema& schema) {
           return pipeline_of(a, schema) == pipeline_of(b, schema);
         });
}

bool is_refusal(const Error& error) noexcept {
  return error.code() == ErrorCode::kNotSupported || error.code() == ErrorCode::kInvalidArgument;
}

std::vector<AttributeId> refined_attributes(const Store& store) {
  std::vector<AttributeId> ids;
  for (AttributeId id = 0; id < store.attributes().size(); ++id)
    if (store.attributes()[id].finest_level > store.base_level()) ids.push_back(id);
  return ids;
}

std::uint64_t level_bytes(const Store& store, AttributeId id, int finest_level) {
  std::uint64_t bytes = 0;
  const int finest = std::min(finest_level, store.attributes()[id].finest_level);
  for (int level = store.base_level() + 1; level <= finest; ++level)
    bytes += StoreAccess::level_file(store, id, level).geometry.total_bytes();
  return bytes;
}

std::uint64_t raw_bytes(const Store& store) {
  std::uint64_t bytes = 0;
  for (const AttributeId id : refined_attributes(store))
    bytes += level_bytes(store, id, store.finest_level());
  return bytes;
}

}  // namespace plait::tune
