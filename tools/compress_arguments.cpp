#include "compress_arguments.h"

#include "arguments.h"

namespace plait {

Compression compression_of(const std::vector<std::string>& texts) {
  Compression compression;
  for (const std::string& text : texts) compression.add(text);
  return compression;
}

PipelinesOf pipelines_of(const std::vector<std::string>& texts, const Store& store) {
  compression_of(texts).check_levels(store.base_level(), store.finest_level());
  return pipelines_of(texts);
}

std::string max_error_help() {
  return "--max-error 1e-5 rounds positions so that no coordinate changes by more than 1e-5, and\n"
         "1e-6rel by more than a millionth of the diagonal of the base vertices' box. With\n"
         ",euclidean, no vertex moves farther. normal=1e-3 rounds normals. Base vertices, and\n"
         "what has no bound, stay exact; plait info prints the errors.";
}

}  // namespace plait
