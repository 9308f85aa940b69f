// plait serve: shows a store in the browser, from this machine.

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "arguments.h"
#include "base/text.h"
#include "command.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "plait/error.h"
#include "plait/store.h"
#include "progress.h"
#include "publish/served_store.h"
#include "serve/http_server.h"

namespace plait {
namespace {

struct ServeArguments {
  std::filesystem::path store;
  ServerAddress address{"127.0.0.1", 8765};
  bool open = false;
  std::uint64_t memory_bytes = OpenOptions().budget_bytes;
};

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

/// Asks the desktop to show the address. A machine without one is told.
void open_browser(const std::string& address) {
  std::string opener = "xdg-open", url = address;
  std::array<char*, 3> words = {opener.data(), url.data(), nullptr};
  pid_t child = 0;
  if (::posix_spawnp(&child, opener.c_str(), nullptr, nullptr, words.data(), environ) != 0) {
    report_warning("xdg-open is not installed: open the address by hand");
    return;
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  if (status != 0) report_warning("xdg-open found no browser: open the address by hand");
}

int run_serve(const ServeArguments& arguments, const CommandContext& context) {
  OpenOptions open;
  open.budget_bytes = arguments.memory_bytes;
  Store store = Store::open(arguments.store, open, context.open_backends);
  ProgressBar progress("view", ProgressUnit::kNone);
  const ServedStore files(
      store, [&](const Progress& now) { return progress.update(now.done, now.total); });
  progress.clear();
  HttpServer server(files, arguments.address);
  const bool is_ip6 = arguments.address.host.find(':') != std::string::npos;
  const std::string& host = arguments.address.host;
  const std::string url =
      fmt::format("http://{}:{}/", is_ip6 ? '[' + host + ']' : host, server.port());
  if (!is_loopback(arguments.address.host))
    report_warning("other machines can read the store: there is no password and no encryption");
  if (context.json)
    print(json_text(nlohmann::ordered_json{{"store", arguments.store.string()},
                                           {"address", url},
                                           {"port", server.port()},
                                           {"view_bytes", files.view_bytes()}}));
  else
    print(fmt::format("{}: {}  (the first view takes {}; Ctrl-C ends)\n", arguments.store.native(),
                      url, format_bytes(files.view_bytes() + viewer_page().size())));
  flush_output();
  if (arguments.open) open_browser(url);
  server.run(interrupted);
  if (!context.json)
    print(fmt::format("{} requests, {}\n", format_count(server.requests()),
                      format_bytes(server.bytes())));
  return kExitDone;
}

}  // namespace

void add_serve_command(CommandLine& program, CommandContext& context) {
  const auto arguments = std::make_shared<ServeArguments>();
  CommandLine* command = program.add_subcommand("serve", "Show a store in the browser");
  command->add_option("STORE", arguments->store, "The store")->required();
  add_whole_option(*command, "--port", arguments->address.port, 0, 65535, "0: any free one")
      ->default_str(std::to_string(arguments->address.port));
  command
      ->add_option("--host", arguments->address.host,
                   "The address to listen at; 0.0.0.0: all of this machine, for others too")
      ->capture_default_str();
  command->add_flag("--open", arguments->open, "Open the page in the browser of the desktop");
  add_size_option(*command, "--memory", arguments->memory_bytes, "Budget for blocks in memory");
  add_plugin_option(*command, context);
  add_json_option(*command, context);
  command->footer(
      "Serves the page that shows the store, and what the page reads of it, until Ctrl-C. The\n"
      "server only reads, and opens no file that a request names. Any backend, compression and\n"
      "shards will do: records are decoded here. If the store has no view of its newest version\n"
      "(plait publish writes one), the command first reads all positions once. A commit of "
      "another\n"
      "program is seen after a new start.\n"
      "\n"
      "Examples:\n"
      "  plait serve surface.plait\n"
      "  plait serve surface.plait --port 0 --open\n"
      "  plait serve surface.plait --host 0.0.0.0 --json");
  command->callback([arguments, &context] {
    context.run = [arguments, &context] { return run_serve(*arguments, context); };
  });
}

}  // namespace plait
