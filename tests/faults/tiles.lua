-- Requests the paths in the file "paths" one after the other, repeatedly.
local paths = {}
for path in io.lines("paths") do paths[#paths + 1] = path end
local number = 0
function request()
  number = number % #paths + 1
  return wrk.format("GET", paths[number])
end
