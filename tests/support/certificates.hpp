// Self-signed certificates for tests of TLS, generated on demand.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>

#include <openssl/bio.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

namespace multitetra::testing {

struct CertificateAndKey {
  std::string certificate;  // PEM
  std::string key;          // PEM
};

template <typename Write>
std::string pem(const Write& write) {
  const std::unique_ptr<BIO, decltype(&BIO_free)> memory(BIO_new(BIO_s_mem()), BIO_free);
  if (write(memory.get()) != 1) throw std::runtime_error("OpenSSL writes no PEM.");
  char* text = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &text);
  return {text, static_cast<std::size_t>(size)};
}

// Returns a self-signed certificate for `names`, valid from `from_seconds` to `until_seconds` from
// now.
inline CertificateAndKey self_signed(const std::string& names = "DNS:localhost,IP:127.0.0.1",
                                     long until_seconds = 3600, long from_seconds = -3600) {
  const std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)> key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  const std::unique_ptr<X509, decltype(&X509_free)> made(X509_new(), X509_free);
  X509* const x = made.get();
  X509_set_version(x, 2);
  ASN1_INTEGER_set(X509_get_serialNumber(x), 1);
  X509_gmtime_adj(X509_getm_notBefore(x), from_seconds);
  X509_gmtime_adj(X509_getm_notAfter(x), until_seconds);
  X509_set_pubkey(x, key.get());
  X509_NAME* const subject = X509_get_subject_name(x);
  X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>("multitetra test"), -1, -1, 0);
  X509_set_issuer_name(x, subject);
  const std::unique_ptr<X509_EXTENSION, decltype(&X509_EXTENSION_free)> alternatives(
      X509V3_EXT_conf_nid(nullptr, nullptr, NID_subject_alt_name, names.c_str()),
      X509_EXTENSION_free);
  if (!alternatives) throw std::runtime_error("No names of a certificate: " + names);
  X509_add_ext(x, alternatives.get(), -1);
  X509_sign(x, key.get(), EVP_sha256());
  return {.certificate = pem([&](BIO* to) { return PEM_write_bio_X509(to, x); }),
          .key = pem([&](BIO* to) {
            return PEM_write_bio_PrivateKey(to, key.get(), nullptr, nullptr, 0, nullptr, nullptr);
          })};
}

}  // namespace multitetra::testing
