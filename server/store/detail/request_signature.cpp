#include "server/store/detail/request_signature.hpp"

#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <ctime>

#include "common/base/hex_text.hpp"
#include "common/base/percent_encoded.hpp"
#include "common/base/text.hpp"
#include "server/store/sha256.hpp"

namespace multitetra {
namespace {

std::string hmac(std::string_view key, std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> code{};
  unsigned int size = 0;
  HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
       reinterpret_cast<const unsigned char*>(text.data()), text.size(), code.data(), &size);
  return {reinterpret_cast<const char*>(code.data()), size};
}

std::string digest_of(std::string_view text) { return sha256_hex(std::as_bytes(std::span(text))); }

// The host as HTTP sends it, the path and the query, sorted.
struct CanonicalUrl {
  std::string host;
  std::string path;
  std::string query;

  explicit CanonicalUrl(std::string_view url) {
    const bool is_https = url.starts_with("https:");
    url.remove_prefix(url.find("//") + 2);
    const std::size_t question = std::min(url.find('?'), url.size());
    const std::size_t slash = std::min(url.find('/'), question);
    host = url.substr(0, slash);
    const std::string_view usual_port = is_https ? ":443" : ":80";
    if (host.ends_with(usual_port)) host.resize(host.size() - usual_port.size());
    // Buckets escape what the path need not have escaped, such as "=".
    path = slash == question ? "/" : percent_encoded(url.substr(slash, question - slash), "/%");
    if (question == url.size()) return;
    std::vector<std::string_view> parts = split(url.substr(question + 1), '&');
    std::sort(parts.begin(), parts.end());
    for (const std::string_view part : parts) {
      query += query.empty() ? "" : "&";
      query += part;
      if (part.find('=') == std::string_view::npos) query += '=';
    }
  }
};

}  // namespace

std::vector<std::string> signature_headers(const SigningKey& key, std::string_view method,
                                           std::string_view url, std::span<const std::byte> body,
                                           std::chrono::system_clock::time_point now) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  std::array<char, 17> time{};
  (void)std::strftime(time.data(), time.size(), "%Y%m%dT%H%M%SZ", &utc);
  const std::string day(time.data(), 8);
  const CanonicalUrl place(url);
  const std::string digest = sha256_hex(body);
  std::vector<std::string> headers = {"host:" + place.host, "x-amz-content-sha256:" + digest,
                                      std::string("x-amz-date:") + time.data()};
  if (!key.session.empty()) headers.push_back("x-amz-security-token:" + key.session);
  std::string names;
  std::string request = std::string(method) + "\n" + place.path + "\n" + place.query + "\n";
  for (const std::string& header : headers) {
    request += header + "\n";
    names += (names.empty() ? "" : ";") + header.substr(0, header.find(':'));
  }
  request += "\n" + names + "\n" + digest;
  const std::string scope = day + "/" + key.region + "/s3/aws4_request";
  const std::string text =
      std::string("AWS4-HMAC-SHA256\n") + time.data() + "\n" + scope + "\n" + digest_of(request);
  const std::string signing =
      hmac(hmac(hmac(hmac("AWS4" + key.secret, day), key.region), "s3"), "aws4_request");
  const std::string code = hmac(signing, text);
  headers.push_back("Authorization: AWS4-HMAC-SHA256 Credential=" + key.id + "/" + scope +
                    ", SignedHeaders=" + names +
                    ", Signature=" + hex_text(std::as_bytes(std::span(code))));
  return headers;
}

}  // namespace multitetra
