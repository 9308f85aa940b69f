#include "final_name.h"

#include <string>

namespace plait {

Error with_final_name(const Error& error, const std::filesystem::path& temporary,
                      const std::filesystem::path& final_path) {
  std::string message = error.what();
  for (std::size_t at = 0; (at = message.find(temporary.native(), at)) != std::string::npos;) {
    message.replace(at, temporary.native().size(), final_path.native());
    at += final_path.native().size();
  }
  return {error.code(), message};
}

}  // namespace plait
