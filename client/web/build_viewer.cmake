# Runs build.sh; reports npm errors without stopping the build.
if(NOT NPM)
  message("!! npm is missing: NO BROWSER VIEWER is built. Everything else works.")
  return()
endif()
execute_process(COMMAND bash ${SCRIPT} ${OUTPUT} RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message("!! The lines above say why: NO BROWSER VIEWER is built (packages come from the network "
          "once). Everything else works.")
endif()
