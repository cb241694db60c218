#include "server/core/refinement_plan.hpp"
