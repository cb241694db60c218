#include "client/load/load_report.hpp"

#include <array>
#include <utility>

#include "common/base/json.hpp"
#include "common/cli/human_units.hpp"
#include "common/json/json_report.hpp"

namespace multitetra {
namespace {

double seconds(std::chrono::milliseconds time) {
  return std::chrono::duration<double>(time).count();
}

using NamedTimes = std::pair<const char*, const Times*>;

std::array<NamedTimes, 5> times_of(const LoadStatistics& s) {
  return {{{"connect", &s.connect},
           {"first_tile", &s.first_tile},
           {"first_step", &s.first_step},
           {"last_tile", &s.last_tile},
           {"whole", &s.whole}}};
}

Json json_of(const Times& times) {
  return {{"count", times.count()},     {"mean", times.mean()},        {"p50", times.quantile(0.5)},
          {"p90", times.quantile(0.9)}, {"p99", times.quantile(0.99)}, {"max", times.quantile(1)}};
}

Json json_of_run(const LoadOptions& options, std::string_view script) {
  return {{"server", to_string(options.session.server)},
          {"script", script},
          {"clients", options.clients},
          {"idle", options.idle},
          {"threads", options.threads},
          {"duration_seconds", seconds(options.duration)},
          {"seed", options.seed}};
}

std::string padded(std::string text, std::size_t width) {
  if (text.size() < width) text.insert(0, width - text.size(), ' ');
  return text;
}

std::string line(const std::string& what, const std::string& value) {
  return what + std::string(what.size() < 24 ? 24 - what.size() : 1, ' ') + value + "\n";
}

std::string times_table(const LoadStatistics& s) {
  constexpr std::size_t kColumn = 12;
  std::string text =
      line("seconds until", padded("half", kColumn) + padded("90 %", kColumn) +
                                padded("99 %", kColumn) + padded("the last", kColumn));
  const std::array<const char*, 5> words = {"the welcome", "the first tile", "the first step",
                                            "the last tile", "the end"};
  const auto all = times_of(s);
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::string cells;
    for (const double part : {0.5, 0.9, 0.99, 1.0}) {
      cells += padded(
          all[i].second->count() == 0 ? "-" : human_number(all[i].second->quantile(part)), kColumn);
    }
    text += line(words[i], cells);
  }
  return text;
}

}  // namespace

std::string json_report(const LoadOptions& options, const LoadStatistics& s) {
  Json json = json_of_run(options, name(options.session.script));
  json["streams"] = {{"started", s.streams},       {"complete", s.complete},
                     {"replaced", s.replaced},     {"failed", s.failed},
                     {"unfinished", s.unfinished}, {"retried_after_delay", s.retried_after_delay}};
  json["steps"] = s.steps;
  json["tiles"] = s.tiles;
  json["tiles_sent_twice"] = s.tiles_sent_twice;
  json["payload_bytes"] = s.payload_bytes;
  json["seconds_until_last_tile"] = s.seconds;
  json["wire_bytes"] = s.wire_bytes;
  json["connections"] = {{"welcomed", s.connections},
                         {"lost", s.lost_connections},
                         {"failed_attempts", s.failed_attempts},
                         {"clients_without", s.clients_without_connection}};
  json["errors"] = Json::object();
  for (const auto& [code, occurrences] : s.errors) {
    json["errors"][code] = {{"count", occurrences.count}, {"example", occurrences.example}};
  }
  json["checks"] = {{"streams_in_full", s.thorough_streams},
                    {"tiles_decoded", s.tiles_decoded},
                    {"steps_compared", s.steps_compared},
                    {"failed", s.checks_failed},
                    {"texts", s.failed_checks}};
  for (const auto& [what, times] : times_of(s)) json["seconds"][what] = json_of(*times);
  return text_of(json);
}

std::string table(const LoadStatistics& s) {
  std::string text = times_table(s);
  text += line("streams", human_count(s.streams) + ": " + human_count(s.complete) + " complete, " +
                              human_count(s.replaced) + " replaced by a new request, " +
                              human_count(s.failed) + " failed, " + human_count(s.unfinished) +
                              " unfinished");
  if (s.retried_after_delay > 0) {
    text += line("rejected and retried", human_count(s.retried_after_delay) + " times");
  }
  const double bytes_per_second =
      s.seconds > 0 ? static_cast<double>(s.payload_bytes) / s.seconds : 0;
  text += line("got", human_count(s.steps) + " steps, " + human_count(s.tiles) + " tiles, " +
                          human_bytes(s.payload_bytes) + " in " + human_seconds(s.seconds) + " (" +
                          human_bytes(static_cast<std::uint64_t>(bytes_per_second)) + " a second)");
  text += line("connections", human_count(s.connections) + ": " + human_count(s.lost_connections) +
                                  " lost; " + human_count(s.failed_attempts) +
                                  " attempts failed; " + human_count(s.clients_without_connection) +
                                  " clients never connected");
  text += line("checked", human_count(s.thorough_streams) + " streams completely, " +
                              human_count(s.tiles_decoded) + " tiles decoded, " +
                              human_count(s.steps_compared) + " steps compared between clients");
  for (const auto& [code, occurrences] : s.errors) {
    text += line("error " + code,
                 human_count(occurrences.count) + ", for example: " + occurrences.example);
  }
  if (s.tiles_sent_twice > 0)
    text += line("SENT TWICE", human_count(s.tiles_sent_twice) + " tiles");
  if (s.checks_failed > 0) text += line("CHECKS FAILED", human_count(s.checks_failed));
  for (const std::string& failed : s.failed_checks) text += "  " + failed + "\n";
  return text;
}

std::string json_report(const LoadOptions& options, Misbehaviour kind,
                        const MisbehaviourCounts& counts) {
  Json json = json_of_run(options, name(kind));
  json["connections"] = {{"made", counts.connections},
                         {"failed_attempts", counts.failed_attempts},
                         {"ended_by_server", counts.ended_by_server}};
  json["bytes_sent"] = counts.bytes_sent;
  return text_of(json);
}

std::string table(Misbehaviour kind, const MisbehaviourCounts& counts) {
  return line(std::string(name(kind)),
              human_count(counts.connections) + " connections, " +
                  human_count(counts.ended_by_server) + " ended by the server, " +
                  human_count(counts.failed_attempts) + " attempts failed, " +
                  human_bytes(counts.bytes_sent) + " sent");
}

}  // namespace multitetra
