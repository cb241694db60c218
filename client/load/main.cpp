// multitetra-load: simulates many clients of a server, which check every reply.
#include <algorithm>
#include <iostream>
#include <string>
#include <thread>

#include "client/commands/program.hpp"
#include "client/commands/server_options.hpp"
#include "client/load/load_report.hpp"
#include "common/cli/command_line.hpp"
#include "common/cli/program.hpp"
#include "common/net/trust.hpp"

namespace multitetra {
namespace {

struct LoadArguments {
  ServerArguments server;
  std::string dataset;
  std::string script = "mixed";
  std::size_t clients = 10;
  std::size_t idle = 0;
  double duration = 10;
  double ramp = -1;
  double grace = 30;
  double pause = 2;
  int isovalues = 32;
  std::vector<double> errors = {0.5, 1, 2, 4};
  std::uint64_t seed = 1;
  int threads = 0;
  std::string simplify = "off";
  std::string from;
  std::string check = "light";
  bool json = false;
};

constexpr const char* kHelp =
    "Scripts of users: random-isovalues (a surface, a pause, then another), drag (the isovalue\n"
    "moves in small steps, 20 a second), roi (a ball of finer errors moves over a surface),\n"
    "mixed. Misbehaving clients: stalled (reads nothing), slow (a byte a second),\n"
    "leaving, garbage, greedy (the most work per request), hoarding (the most memory per "
    "request).\n"
    "Checks: light checks one stream of 16 as multitetra-client does, and of the others the\n"
    "manifests, counts, sums of digests and one tile of 16; full checks all. Every step is "
    "compared\n"
    "with those of other clients for the same parameters.\n"
    "Rejected clients retry after the delay in the reply.\n"
    "A server accepts 256 connections and 200 requests a second from one address. For more, start\n"
    "it with: serve --max-connections 20000 --max-connections-per-address 20000\n"
    "--max-requests-per-second 1000000.\n"
    "Examples:\n"
    "  multitetra-load --server ws://127.0.0.1:7480 --clients 1000 --duration 60\n"
    "  multitetra-load --server ws://127.0.0.1:7480 --clients 2000 --idle 10000 --duration 120\n"
    "  multitetra-load --script drag --clients 20 --duration 10 --json\n"
    "Exit codes: 0 done, 1 streams failed or did not finish, 2 wrong usage, 3 a check failed.";

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000));
}

void add_options(Command& app, LoadArguments& a) {
  add_server_options(app, a.server);
  app.add_option("--dataset", a.dataset, "Request this dataset only");
  app.add_option("--script", a.script, "What the clients do")
      ->one_of({"random-isovalues", "drag", "roi", "mixed", "stalled", "slow", "leaving", "garbage",
                "greedy", "hoarding"})
      ->capture_default_str();
  app.add_option("--clients", a.clients, "Number of clients")
      ->within(1, 100'000)
      ->capture_default_str();
  app.add_option("--duration", a.duration, "Seconds during which they send requests")
      ->within(0.1, 86400.0)
      ->capture_default_str();
  app.add_option("--check", a.check, "Checks of each stream")
      ->one_of({"light", "full"})
      ->capture_default_str();
  app.add_option("--seed", a.seed, "The same seed gives the same scripts")->capture_default_str();
  app.add_flag("--json", a.json, "Print JSON");
  app.begin_group("Scripts");
  app.add_option("--idle", a.idle, "Number of additional idle connections, opened first")
      ->within(0, 100'000)
      ->capture_default_str();
  app.add_option("--ramp", a.ramp,
                 "Seconds over which clients connect; default: 1 for 200 clients, at most a "
                 "quarter of the duration");
  app.add_option("--grace", a.grace, "Seconds after the duration for running streams")
      ->within(0.0, 86400.0)
      ->capture_default_str();
  app.add_option("--pause", a.pause, "Mean time in seconds for which a user looks at a surface")
      ->within(0.0, 3600.0)
      ->capture_default_str();
  app.add_option("--isovalues", a.isovalues, "Number of different isovalues")
      ->within(1, 1'000'000)
      ->capture_default_str();
  app.add_option("--errors", a.errors, "Errors of the requests, in voxels")
      ->within(0.0, 1e6)
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--simplify", a.simplify, "on: simplified meshes; off: all triangles")
      ->one_of({"on", "off"})
      ->capture_default_str();
  app.add_option("--from", a.from,
                 "Connect from these addresses of this machine, each client from the next one "
                 "(127.0.1.0/24)")
      ->type_name("NETWORK");
  app.add_option("--threads", a.threads, "Threads of this program; 0: one for each two processors")
      ->within(0, 256)
      ->capture_default_str();
  app.footer(kHelp);
}

Result<LoadOptions> options_of(const LoadArguments& a) {
  const auto access = access_of(a.server);
  if (!access) return tl::unexpected(access.error());
  const auto from =
      a.from.empty() ? Result<SourceAddresses>(SourceAddresses()) : SourceAddresses::from(a.from);
  if (!from) return tl::unexpected(from.error());
  const int processors = static_cast<int>(std::thread::hardware_concurrency());
  LoadOptions options{
      .session = {.server = access->server,
                  .token = access->options.token,
                  .dataset = a.dataset,
                  .script = script_kind_from(a.script).value_or(ScriptKind::kMixed),
                  .script_options = {.isovalues = a.isovalues,
                                     .errors = a.errors,
                                     .simplify = a.simplify == "on",
                                     .mean_pause = milliseconds(a.pause)},
                  .timeout = access->options.timeout},
      .seed = a.seed,
      .clients = a.clients,
      .idle = a.idle,
      .threads = a.threads > 0 ? a.threads : std::max(processors / 2, 1),
      .from = *from,
      .duration = milliseconds(a.duration),
      .ramp = milliseconds(
          a.ramp >= 0 ? a.ramp
                      : std::min(static_cast<double>(a.clients + a.idle) / 200, a.duration / 4)),
      .grace = milliseconds(a.grace)};
  if (a.check == "full") {
    options.session.streams_per_thorough = 1;
    options.session.tiles_per_decoded = 1;
  }
  if (access->server.is_secure()) {
    auto tls = client_tls(access->options.trust);
    if (!tls) return tl::unexpected(tls.error());
    options.session.tls = *std::move(tls);
  }
  return options;
}

int exit_code(const LoadStatistics& s) {
  if (s.checks_failed > 0 || s.tiles_sent_twice > 0) return kCheckFailed;
  const bool is_good = s.failed == 0 && s.unfinished == 0 && s.clients_without_connection == 0;
  return is_good && s.steps > 0 ? kOk : kFailed;
}

int run(int argc, char** argv) {
  Command app("Simulates clients of a Multi-Tetra server and checks the replies.",
              "multitetra-load");
  add_program_flags(app);
  LoadArguments arguments;
  add_options(app, arguments);
  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  const auto options = options_of(arguments);
  if (!options) throw ExitError(kUsage, options.error().text);
  if (const auto room = allow_connections(options->clients + options->idle); !room) {
    throw ExitError(kUsage, room.error().text);
  }
  if (const auto nuisance = misbehaviour_from(arguments.script)) {
    const MisbehaviourCounts counts = run_misbehaviour(*nuisance, *options);
    std::cout << (arguments.json ? json_report(*options, *nuisance, counts)
                                 : table(*nuisance, counts));
    return counts.connections > 0 ? kOk : kFailed;
  }
  const LoadStatistics statistics = run_load(*options);
  std::cout << (arguments.json ? json_report(*options, statistics) : table(statistics));
  return exit_code(statistics);
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  return multitetra::run_program("multitetra-load", [&] { return multitetra::run(argc, argv); });
}
